set(on_virtual_board "toolchains/dev guest >&2 && ${Python3_EXECUTABLE} -B tests/bench/virtual_board.py")
plenum_bench(NAME board.boot_to_heartbeat_s COMMAND sh -c "${on_virtual_board} boot")
plenum_bench(NAME board.rss_mib COMMAND sh -c "${on_virtual_board} memory")
