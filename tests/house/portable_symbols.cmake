# Rejects bakes that call functions of glibc whose bits differ on arm64, and the runtime that serves them.
# usage: cmake -DNM= -DRUNTIME= -DBAKES=list -P this
function(reject functions)
  execute_process(COMMAND ${NM} --undefined-only ${ARGN} OUTPUT_VARIABLE symbols COMMAND_ERROR_IS_FATAL ANY)
  if(NOT symbols MATCHES " U pow\n")  # nothing was read
    message(FATAL_ERROR "${ARGN} call no pow, which they do")
  endif()
  string(REGEX MATCHALL " U (${functions})\n" found "${symbols}")
  if(found)
    message(FATAL_ERROR "on arm64 these give other bits (norm, cube_root and angle_of do not):${found}")
  endif()
endfunction()
reject("(hypot|cbrt|exp2)f?" ${RUNTIME})
reject("(hypot|cbrt|exp2)f?|(tan|atan|atan2|acos|asin|log)f" ${BAKES})
