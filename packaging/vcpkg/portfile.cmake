# Untested. An overlay port on the sources that it stands in: vcpkg install sqmap --overlay-ports=packaging/vcpkg
get_filename_component(SOURCE_PATH "${CURRENT_PORT_DIR}/../.." ABSOLUTE)
vcpkg_cmake_configure(SOURCE_PATH "${SOURCE_PATH}" OPTIONS
  -DSQMAP_BUILD_TESTS=OFF -DSQMAP_BUILD_APPS=OFF -DSQMAP_BUILD_BENCH=OFF -DSQMAP_BUILD_C=ON
  "-DSQMAP_FLATC=${CURRENT_HOST_INSTALLED_DIR}/tools/flatbuffers/flatc")
vcpkg_cmake_install()
vcpkg_cmake_config_fixup(CONFIG_PATH lib/cmake/sqmap)
vcpkg_fixup_pkgconfig()
file(REMOVE_RECURSE "${CURRENT_PACKAGES_DIR}/debug/include")
vcpkg_install_copyright(FILE_LIST "${SOURCE_PATH}/LICENSE")
