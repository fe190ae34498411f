include(CMakePackageConfigHelpers)
install(TARGETS ${SQMAP_LIBRARIES} EXPORT sqmapTargets FILE_SET HEADERS)
if(TARGET sqmap_sim)
  install(TARGETS sqmap_sim EXPORT sqmapTargets FILE_SET HEADERS)
endif()
if(TARGET sqmap_c)
  install(TARGETS sqmap_c EXPORT sqmapTargets FILE_SET HEADERS)
  # The prefix by way of the file itself: what is installed may be moved.
  file(RELATIVE_PATH SQMAP_PREFIX_OF_PC /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
  configure_file(cmake/sqmap.pc.in ${PROJECT_BINARY_DIR}/sqmap.pc @ONLY)
  install(FILES ${PROJECT_BINARY_DIR}/sqmap.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
endif()
install(EXPORT sqmapTargets NAMESPACE sqmap:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/sqmap)
# Libraries, by name, that sqmap::hardware was built to link.
get_property(SQMAP_HARDWARE_LIBRARIES GLOBAL PROPERTY SQMAP_HARDWARE_LIBRARIES)
configure_package_config_file(cmake/sqmapConfig.cmake.in ${PROJECT_BINARY_DIR}/sqmapConfig.cmake
  INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/sqmap)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/sqmapConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/sqmapConfig.cmake ${PROJECT_BINARY_DIR}/sqmapConfigVersion.cmake
  DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/sqmap)
if(TARGET sqmap)
  install(TARGETS sqmap)
endif()
