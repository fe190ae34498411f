# Puts the files of the page into a C++ source: cmake -DDIST=<folder> -DOUTPUT=<file.cpp> -P embed.cmake
# The assembler takes them in as they are, which takes no time whatever their size.
set(body "")
set(table "")
set(any false)
foreach(name index.html app.js app.css favicon.svg)
  if(EXISTS "${DIST}/${name}")
    string(MAKE_C_IDENTIFIER "sqmap_page_${name}" id)
    string(APPEND body "asm(\".pushsection .rodata\\n.global ${id}\\n${id}:\\n.incbin \\\"${DIST}/${name}\\\"\\n.global ${id}_end\\n${id}_end:\\n.byte 0\\n.popsection\\n\");\n")
    string(APPEND body "extern \"C\" const char ${id}[];\nextern \"C\" const char ${id}_end[];\n")
    string(APPEND table "    if (name == \"${name}\") return {${id}, static_cast<std::size_t>(${id}_end - ${id})};\n")
    set(any true)
  endif()
endforeach()
file(CONFIGURE OUTPUT "${OUTPUT}" @ONLY CONTENT [==[
#include "viewer/server/http/page.h"

@body@
namespace sqmap::viewer {

std::string_view page_file([[maybe_unused]] std::string_view name) noexcept
{
@table@    return {};
}

bool has_page() noexcept { return @any@; }

}  // namespace sqmap::viewer
]==])
