plenum_bench(NAME board.deb_mib
  COMMAND sh -c "toolchains/dev package >&2 && ${Python3_EXECUTABLE} -B tests/bench/deb.py build/host/package/plenumd_*.deb")
