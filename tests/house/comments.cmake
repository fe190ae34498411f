# Doxygen finds a comment on every public type and function of the headers, and each header says which threads may call it. Members
# of structs, operators and special members are their type's affair.
# usage: cmake -DDOXYGEN=... -DINCLUDE=... -DWORK=... -P comments.cmake
# Doxygen misses functions of a namespace that itself has no comment.
file(GLOB folders RELATIVE ${INCLUDE}/sqmap LIST_DIRECTORIES ON ${INCLUDE}/sqmap/*)
list(FILTER folders EXCLUDE REGEX "\\.h$")
set(namespaces "/// The library.\nnamespace sqmap {\n")
foreach(folder IN LISTS folders)
  string(APPEND namespaces "/// A folder.\nnamespace ${folder} {}\n")
endforeach()
file(WRITE ${WORK}/namespaces.h "${namespaces}}\n")
file(WRITE ${WORK}/Doxyfile "INPUT = ${WORK}/namespaces.h ${INCLUDE}\nRECURSIVE = YES\nFILE_PATTERNS = *.h\nEXCLUDE_PATTERNS = *_impl.h\nOUTPUT_DIRECTORY = ${WORK}
GENERATE_HTML = NO\nGENERATE_LATEX = NO\nGENERATE_XML = YES\nJAVADOC_AUTOBRIEF = YES\nAUTOLINK_SUPPORT = NO\nDISTRIBUTE_GROUP_DOC = YES
MACRO_EXPANSION = YES\nEXPAND_ONLY_PREDEF = YES\nPREDEFINED = SQMAP_API=\nQUIET = YES\nWARN_IF_UNDOCUMENTED = YES
ALIASES = \"pre=@par Precondition:^^\" \"throw=@par Throws:^^\"\n")
execute_process(COMMAND ${DOXYGEN} ${WORK}/Doxyfile OUTPUT_QUIET ERROR_VARIABLE warnings COMMAND_ERROR_IS_FATAL ANY)
string(REGEX REPLACE "[^\n]*(\\(variable\\)|\\(friend\\)|operator|&&)[^\n]*\n" "" warnings "${warnings}")
file(GLOB_RECURSE headers ${INCLUDE}/sqmap/*.h)
foreach(header IN LISTS headers)
  file(STRINGS ${header} threads REGEX "[Tt]hread")
  if(NOT threads AND NOT header MATCHES "_impl.h$|sqmap/sqmap.h$")
    string(APPEND warnings "${header}: says nothing of threads: which may call it, how many at once\n")
  endif()
endforeach()
if(warnings)
  message(FATAL_ERROR "${warnings}")
endif()
