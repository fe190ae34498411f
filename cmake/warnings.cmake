# Warnings and floating-point rules of the project's own targets; never passed on to users.
add_library(sqmap_options INTERFACE)
target_compile_options(sqmap_options INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion
  -Wno-restrict  # GCC 12 warns of every "text" + std::string (its bug 105651)
  # A fused multiply-add changes results between machines: models must have the same bytes everywhere.
  -ffp-contract=off)
if(SQMAP_WERROR)
  target_compile_options(sqmap_options INTERFACE -Werror)
endif()
