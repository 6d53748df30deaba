# What is installed beside libraries and program, and the packages that `cpack` makes of it.
include(CMakePackageConfigHelpers)
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/gpvc)
configure_package_config_file(app/setup/gpvcConfig.cmake.in ${PROJECT_BINARY_DIR}/gpvcConfig.cmake
                              INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/gpvcConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/gpvcConfig.cmake ${PROJECT_BINARY_DIR}/gpvcConfigVersion.cmake
        DESTINATION ${package_dir} COMPONENT library)

# gpvc::gpvc, which most programs link. BUILD_SHARED_LIBS: all libraries as one shared one, of which nothing is seen but the
# namespace gpvc; else a name for the static ones.
if(BUILD_SHARED_LIBS)
  add_library(gpvc_all SHARED)
  foreach(library io visibility labeling atlas results checks pipeline tileset)
    target_sources(gpvc_all PRIVATE $<TARGET_OBJECTS:gpvc_${library}>)
  endforeach()
  target_sources(gpvc_all PRIVATE $<TARGET_OBJECTS:gpvc_raster_writer>)
  target_link_libraries(gpvc_all PRIVATE gpvc_tileset)  # for what these need; nothing of theirs is missing any more
  set(symbols ${PROJECT_SOURCE_DIR}/app/setup/gpvc.map)
  target_link_options(gpvc_all PRIVATE LINKER:--version-script=${symbols})
  set_target_properties(gpvc_all PROPERTIES OUTPUT_NAME gpvc LINKER_LANGUAGE CXX VERSION ${PROJECT_VERSION}
    SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR} LINK_DEPENDS ${symbols} INSTALL_RPATH "$ORIGIN/gpvc")
  foreach(module gpvc_formats_module gpvc_rasters_module)
    if(TARGET ${module})  # not where another project builds gpvc along: it is linked in
      install(TARGETS ${module} LIBRARY DESTINATION ${GPVC_MODULE_DIR} COMPONENT library)
    endif()
  endforeach()
  target_compile_features(gpvc_all PUBLIC cxx_std_20)
  target_include_directories(gpvc_all INTERFACE
    $<BUILD_INTERFACE:${PROJECT_BINARY_DIR}/include> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  file(RELATIVE_PATH prefix_from_pc ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig ${CMAKE_INSTALL_PREFIX})
  configure_file(app/setup/gpvc.pc.in ${PROJECT_BINARY_DIR}/gpvc.pc @ONLY)
  install(FILES ${PROJECT_BINARY_DIR}/gpvc.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT library)
else()
  add_library(gpvc_all INTERFACE)
  target_link_libraries(gpvc_all INTERFACE gpvc_tileset)
endif()
add_library(gpvc::gpvc ALIAS gpvc_all)
set_target_properties(gpvc_all PROPERTIES EXPORT_NAME gpvc)
install(TARGETS gpvc_all EXPORT gpvcTargets LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT library)
install(FILES app/setup/gpvc.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/gpvc COMPONENT library)
install(EXPORT gpvcTargets NAMESPACE gpvc:: DESTINATION ${package_dir} COMPONENT library)

# Man pages are the help; completions ask the program.
set(man_pages ${PROJECT_BINARY_DIR}/man)
install(CODE "execute_process(COMMAND ${CMAKE_COMMAND} -DGPVC=$<TARGET_FILE:gpvc> -DOUTPUT=${man_pages}
  -P ${PROJECT_SOURCE_DIR}/app/setup/man_pages.cmake COMMAND_ERROR_IS_FATAL ANY)" COMPONENT program)
install(DIRECTORY ${man_pages}/ DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT program)
install(FILES app/setup/completion.bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME gpvc
        COMPONENT program)
install(FILES app/setup/completion.zsh DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/vendor-completions RENAME _gpvc
        COMPONENT program)
install(DIRECTORY app/workflow DESTINATION ${CMAKE_INSTALL_DATADIR}/gpvc COMPONENT program)

if(PROJECT_IS_TOP_LEVEL)
  find_program(GPVC_SHLIBDEPS dpkg-shlibdeps DOC "Tells what a Debian package depends on; without it cpack makes an archive")
  set(CPACK_GENERATOR TGZ)
  if(GPVC_SHLIBDEPS)
    set(CPACK_GENERATOR DEB)
  endif()
  set(CPACK_PACKAGE_CONTACT "gpvc's maintainers")
  set(CPACK_PACKAGE_DESCRIPTION_SUMMARY ${PROJECT_DESCRIPTION})
  set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
  set(CPACK_STRIP_FILES ON)
  set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
  set(CPACK_DEBIAN_PACKAGE_SECTION science)
  set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
  # Opened at run time, and only for --drawing opengl.
  set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "libegl1, libgl1-mesa-dri")
  set(CPACK_DEBIAN_PACKAGE_SUGGESTS "snakemake, python3-numpy")
  include(CPack)
endif()
