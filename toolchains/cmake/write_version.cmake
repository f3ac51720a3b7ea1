# cmake -D VERSION=0.1.0 -D SCALAR=float -D TOP=SOURCES -D TO=FOLDER -P write_version.cmake
#
# Writes the version of what is built, to FOLDER/version.txt and as kVersion to FOLDER/plenum_version.hpp, where it has changed:
#   0.1.0+git20261124023000.0123456789ab[.changed][+fixed]
# the project's, the time [UTC] and hash of the commit, whether sources have changed since, and whether the core computes in fixed
# point. A later commit is a later version for dpkg, so that a package can be updated and rolled back. Without a repository it is the
# project's alone.
set(ENV{TZ} UTC)
execute_process(COMMAND git -C ${TOP} log -1 --format=git%cd.%H --date=format-local:%Y%m%d%H%M%S
                OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
execute_process(COMMAND git -C ${TOP} status --porcelain --untracked-files=no
                OUTPUT_VARIABLE changed OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
set(version ${VERSION})
if(commit MATCHES "^(git[0-9]+\\.[0-9a-f][0-9a-f][0-9a-f][0-9a-f][0-9a-f][0-9a-f][0-9a-f][0-9a-f][0-9a-f][0-9a-f][0-9a-f][0-9a-f])")
  string(APPEND version "+${CMAKE_MATCH_1}")
  if(changed)
    string(APPEND version ".changed")
  endif()
endif()
set(scalar "float")
if(SCALAR STREQUAL fixed)
  string(APPEND version "+fixed")
  set(scalar "fixed point")
endif()
file(CONFIGURE OUTPUT ${TO}/version.txt CONTENT "${version}\n")
file(CONFIGURE OUTPUT ${TO}/plenum_version.hpp CONTENT "// Written by toolchains/cmake/write_version.cmake.
#pragma once

inline constexpr const char* kVersion = \"${version}\";
inline constexpr const char* kScalar = \"${scalar}\";  // what the core computes in
")
