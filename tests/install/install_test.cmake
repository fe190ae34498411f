# Installs the built project to a folder of its own, builds consumers against it and runs them: one that bakes and
# queries, one that only queries.
# usage: cmake -DBUILD= -DWORK= -DCONSUMER= -DCONFIG= -DFLAGS= -P this
file(REMOVE_RECURSE ${WORK})
function(run)
  execute_process(COMMAND ${ARGN} WORKING_DIRECTORY ${WORK} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT result EQUAL 0)
    list(JOIN ARGN " " command)
    message(FATAL_ERROR "${command}\n${output}")
  endif()
endfunction()
file(MAKE_DIRECTORY ${WORK})
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/prefix --config ${CONFIG})
run(${WORK}/prefix/bin/sqmap --version)
foreach(components "runtime io build" "runtime io")
  string(MAKE_C_IDENTIFIER "${components}" name)
  run(${CMAKE_COMMAND} -S ${CONSUMER} -B ${WORK}/${name} -G Ninja -DCMAKE_BUILD_TYPE=${CONFIG}
    -DCMAKE_PREFIX_PATH=${WORK}/prefix -DCMAKE_CXX_FLAGS=${FLAGS} "-DCOMPONENTS=${components}")
  run(${CMAKE_COMMAND} --build ${WORK}/${name})
  run(${WORK}/${name}/consumer)
endforeach()
