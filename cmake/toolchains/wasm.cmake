# WebAssembly by Debian's emscripten: SIMD of 128 bits, one thread. SQMAP_PREFIX: headers and CMake packages that ./dev anywhere
# gathers.
set(CMAKE_CXX_FLAGS_INIT "-msimd128 -fwasm-exceptions -isystem ${SQMAP_PREFIX}/include")
set(CMAKE_C_FLAGS_INIT "-msimd128")
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES SQMAP_PREFIX)
set(CMAKE_FIND_ROOT_PATH ${SQMAP_PREFIX})
include(/usr/share/emscripten/cmake/Modules/Platform/Emscripten.cmake)
set(SQMAP_STATIC_VECTORS ON CACHE BOOL "")
