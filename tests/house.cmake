# Tests of the house itself: the order of the folders, the symbols of the runtime, the installed package.
find_package(Python3 REQUIRED COMPONENTS Interpreter)

add_test(NAME house.layers COMMAND Python3::Interpreter ${PROJECT_SOURCE_DIR}/scripts/check_layers.py ${PROJECT_SOURCE_DIR})
add_test(NAME house.layers_check_finds_bad_includes
  COMMAND Python3::Interpreter ${CMAKE_CURRENT_SOURCE_DIR}/layers/check_layers_test.py)

# Links and paths of the documentation.
add_test(NAME house.docs COMMAND Python3::Interpreter ${PROJECT_SOURCE_DIR}/scripts/check_docs.py ${PROJECT_SOURCE_DIR})
add_test(NAME house.docs_check_finds_bad_links
  COMMAND Python3::Interpreter ${CMAKE_CURRENT_SOURCE_DIR}/docs/check_docs_test.py)

# The reproduction's charts, page and shapes, without a run.
add_test(NAME house.reproduction
  COMMAND Python3::Interpreter ${CMAKE_CURRENT_SOURCE_DIR}/bench/reproduce_test.py)
add_test(NAME house.measurements_say_where_they_come_from
  COMMAND Python3::Interpreter ${CMAKE_CURRENT_SOURCE_DIR}/bench/measure_test.py)

# The README quotes the first example as it is compiled.
add_test(NAME house.readme_quotes_the_example
  COMMAND ${CMAKE_COMMAND} -DTEXT=${PROJECT_SOURCE_DIR}/README.md -DQUOTED=${PROJECT_SOURCE_DIR}/examples/01_query.cpp
    -P ${CMAKE_CURRENT_SOURCE_DIR}/quotes.cmake)

# Sanitizers add symbols of their own to every archive.
if(NOT CMAKE_CXX_FLAGS MATCHES "-fsanitize")
  set(check ${CMAKE_CURRENT_SOURCE_DIR}/realtime_symbols.cmake)
  add_test(NAME house.runtime_has_no_forbidden_symbol
    COMMAND ${CMAKE_COMMAND} -DNM=${CMAKE_NM} -DARCHIVE=$<TARGET_FILE:sqmap_runtime> -P ${check})
  # The build library allocates and throws: a check that passes it checks nothing.
  add_test(NAME house.symbol_check_finds_forbidden_symbols
    COMMAND ${CMAKE_COMMAND} -DNM=${CMAKE_NM} -DARCHIVE=$<TARGET_FILE:sqmap_build> -P ${check})
  set_tests_properties(house.symbol_check_finds_forbidden_symbols 
    PROPERTIES PASS_REGULAR_EXPRESSION "the real-time contract forbids")
endif()

if(TARGET sqmap)
  add_test(NAME house.install_and_consume
    COMMAND ${CMAKE_COMMAND} -DBUILD=${PROJECT_BINARY_DIR} -DWORK=${PROJECT_BINARY_DIR}/install-test
      -DCONSUMER=${CMAKE_CURRENT_SOURCE_DIR}/install/consumer -DCONFIG=$<CONFIG> "-DFLAGS=${CMAKE_CXX_FLAGS}"
      -P ${CMAKE_CURRENT_SOURCE_DIR}/install/install_test.cmake)
endif()
