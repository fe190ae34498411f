# Warnings and floating-point rules of the project's own targets; never passed on to users.
add_library(sqmap_options INTERFACE)
target_compile_options(sqmap_options INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion
  -Wno-restrict  # GCC 12 warns of every "text" + std::string (its bug 105651)
  # A fused multiply-add changes results between machines: models must have the same bytes everywhere.
  -ffp-contract=off
  # GCC 12 at -O2 drops the rounding of two doubles to float and back where it makes a vector of them.
  $<$<AND:$<CXX_COMPILER_ID:GNU>,$<CONFIG:RelWithDebInfo>>:-fno-tree-slp-vectorize>)
if(SQMAP_UNITY AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  target_compile_options(sqmap_options INTERFACE -Wno-subobject-linkage)  # GCC takes each source of a unity source for a header
endif()
# GCC collects garbage each time its heap has doubled. Most sources fit into half a gibibyte without, in a tenth less time. A compiler
# cache takes another option for another compilation, and so keeps the default.
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  target_compile_options(sqmap_options INTERFACE --param=ggc-min-heapsize=524288)
endif()
if(SQMAP_WERROR)
  target_compile_options(sqmap_options INTERFACE -Werror)
endif()
