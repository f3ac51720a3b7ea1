plenum_bench(NAME sdo.fuzz_execs
  COMMAND sh -c "toolchains/dev build fuzz >&2 && ${Python3_EXECUTABLE} -B toolchains/fuzz.py build/fuzz tests/fuzz/corpus 300 --row")
