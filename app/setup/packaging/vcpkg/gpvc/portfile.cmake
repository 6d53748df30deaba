# An overlay port of the tree that it lies in:
#   vcpkg install gpvc:x64-linux-dynamic --overlay-ports=app/setup/packaging/vcpkg
# A shared library: what gpvc is made of stays private, and programs need nothing else to be found.
vcpkg_check_linkage(ONLY_DYNAMIC_LIBRARY)
get_filename_component(SOURCE_PATH "${CURRENT_PORT_DIR}/../../../../.." ABSOLUTE)

vcpkg_find_acquire_program(PKGCONFIG)
vcpkg_cmake_configure(
  SOURCE_PATH "${SOURCE_PATH}"
  OPTIONS
    -DBUILD_SHARED_LIBS=ON
    -DGPVC_PYTHON=OFF
    "-DPKG_CONFIG_EXECUTABLE=${PKGCONFIG}"
    "-DTinyGLTF_DIR=${SOURCE_PATH}/app/setup/packaging/tinygltf")
vcpkg_cmake_install()
vcpkg_cmake_config_fixup(CONFIG_PATH lib/cmake/gpvc)
vcpkg_fixup_pkgconfig()
vcpkg_copy_tools(TOOL_NAMES gpvc AUTO_CLEAN)
file(REMOVE_RECURSE "${CURRENT_PACKAGES_DIR}/debug/include" "${CURRENT_PACKAGES_DIR}/debug/share")
file(WRITE "${CURRENT_PACKAGES_DIR}/share/${PORT}/copyright" "The licence is still the owner's to choose.\n")
