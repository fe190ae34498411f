# Windows on x86-64 by Debian's mingw-w64 with its own threads; GCC's libraries are linked in. SSE 4.2: GCC does not align the
# stack for wider vectors there (its bug 54412). No errno: else sqrt is called where size counts, and mingw-w64's rounds twice.
# SQMAP_PREFIX: headers and CMake packages that ./dev anywhere gathers.
set(CMAKE_SYSTEM_NAME Windows)
set(CMAKE_SYSTEM_PROCESSOR x86_64)
set(CMAKE_C_COMPILER x86_64-w64-mingw32-gcc-posix)
set(CMAKE_CXX_COMPILER x86_64-w64-mingw32-g++-posix)
set(CMAKE_RC_COMPILER x86_64-w64-mingw32-windres)
set(CMAKE_C_FLAGS_INIT "-march=x86-64-v2 -maes -mpclmul -isystem ${SQMAP_PREFIX}/include")
set(CMAKE_CXX_FLAGS_INIT "-march=x86-64-v2 -fno-math-errno -maes -mpclmul -isystem ${SQMAP_PREFIX}/include")
set(CMAKE_EXE_LINKER_FLAGS_INIT "-static")
set(CMAKE_CROSSCOMPILING_EMULATOR /usr/bin/wine)
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES SQMAP_PREFIX)
set(CMAKE_FIND_ROOT_PATH /usr/x86_64-w64-mingw32 ${SQMAP_PREFIX})
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
set(SQMAP_STATIC_VECTORS ON CACHE BOOL "")
