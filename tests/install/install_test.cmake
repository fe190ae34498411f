# Installs the built project to a folder of its own, builds consumers against it and runs them: one that bakes and
# queries, one that only queries, one that drives a device, one that opens any device by name, and one in C, by find_package
# and by pkg-config.
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
foreach(components "bake_mesh" "runtime io" "runtime io device" "runtime io hardware")
  string(MAKE_C_IDENTIFIER "${components}" name)
  run(${CMAKE_COMMAND} -S ${CONSUMER} -B ${WORK}/${name} -G Ninja -DCMAKE_BUILD_TYPE=${CONFIG}
    -DCMAKE_PREFIX_PATH=${WORK}/prefix -DCMAKE_CXX_FLAGS=${FLAGS} "-DCOMPONENTS=${components}")
  run(${CMAKE_COMMAND} --build ${WORK}/${name})
  # Whoever brings a device of their own must not have to link what ours need.
  file(READ ${WORK}/${name}/build.ninja rules)
  if(NOT components MATCHES "hardware" AND rules MATCHES "-lSDL2|-lspnav|libSDL2|libspnav")
    message(FATAL_ERROR "a program without sqmap::hardware was made to link its libraries")
  endif()
  run(${WORK}/${name}/consumer)
endforeach()

file(GLOB library ${WORK}/prefix/lib*/libsqmap.so.0 ${WORK}/prefix/lib/*/libsqmap.so.0)
if(library)
  foreach(component c c_query)
    run(${CMAKE_COMMAND} -S ${CONSUMER}_c -B ${WORK}/${component} -G Ninja -DCMAKE_BUILD_TYPE=${CONFIG}
      -DCMAKE_PREFIX_PATH=${WORK}/prefix -DCMAKE_C_FLAGS=${FLAGS} -DCOMPONENT=${component})
    run(${CMAKE_COMMAND} --build ${WORK}/${component})
    run(${WORK}/${component}/consumer)
  endforeach()
  find_program(PKG_CONFIG pkg-config)
  if(PKG_CONFIG)
    cmake_path(GET library PARENT_PATH folder)
    foreach(name sqmap sqmap_query)
      execute_process(COMMAND ${CMAKE_COMMAND} -E env PKG_CONFIG_PATH=${folder}/pkgconfig ${PKG_CONFIG} --cflags --libs ${name}
        OUTPUT_VARIABLE flags OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
      separate_arguments(flags UNIX_COMMAND "${flags} ${FLAGS}")
      run(cc -std=c11 -Wall -Wextra -pedantic -Werror ${CONSUMER}_c/main.c -o from_pkg_config_${name} ${flags}
        -Wl,-rpath,${folder})
      run(${WORK}/from_pkg_config_${name})
    endforeach()
  else()
    message(STATUS "without pkg-config, the program in C is built by find_package alone")
  endif()
endif()
