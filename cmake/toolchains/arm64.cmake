# Linux on arm64 by Debian's cross compiler. SQMAP_PREFIX: headers and CMake packages that ./dev anywhere gathers.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_C_COMPILER aarch64-linux-gnu-gcc)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)
set(CMAKE_LIBRARY_ARCHITECTURE aarch64-linux-gnu)
set(CMAKE_CROSSCOMPILING_EMULATOR qemu-aarch64 -L /usr/aarch64-linux-gnu)
# Highway 1.0.3 marks its functions so, and GCC inlines nothing into lambdas that are not.
set(CMAKE_CXX_FLAGS_INIT "-march=armv8-a+crypto -isystem ${SQMAP_PREFIX}/include")
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES SQMAP_PREFIX)
set(CMAKE_FIND_ROOT_PATH /usr/aarch64-linux-gnu ${SQMAP_PREFIX})
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
set(SQMAP_STATIC_VECTORS ON CACHE BOOL "")  # NEON; no arm64 package is needed
