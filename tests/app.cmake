gpvc_test(city_test gpvc_app)
gpvc_test(modes_texture_gl_test gpvc_app)
gpvc_test(scene_writer_test gpvc_app)
gpvc_test(synth_test gpvc_app)
gpvc_test(truth_test gpvc_app)
gpvc_test(frame_check_test gpvc_app)
gpvc_test(coverage_store_test gpvc_app)
gpvc_test(output_folder_test gpvc_app)
gpvc_test(viewpoint_test gpvc_app)

# The program itself, on a small scene that it makes once.
find_package(OpenMesh REQUIRED)
set(app_scene ${CMAKE_CURRENT_BINARY_DIR}/app_scene)
add_test(NAME app_scene.synth COMMAND gpvc synth city -o ${app_scene} --faces 5000 --size 50 --photos 5
                                      --photo-size 240x160 --force --quiet)
set_tests_properties(app_scene.synth PROPERTIES FIXTURES_SETUP app_scene LABELS gpu)
gpvc_test_program(program_gl_tests FIXTURES_REQUIRED app_scene)
target_sources(program_gl_tests PRIVATE app_test.cpp app_evaluate_test.cpp app_input_test.cpp app_output_test.cpp
                                        output_options_test.cpp visibility_command_test.cpp)
target_link_libraries(program_gl_tests PRIVATE gpvc_app OpenMeshCore)
target_compile_definitions(program_gl_tests PRIVATE GPVC_BINARY="$<TARGET_FILE:gpvc>" GPVC_APP_SCENE="${app_scene}")
# See gltf_files_test in io.cmake.
set_source_files_properties(output_options_test.cpp PROPERTIES
  COMPILE_OPTIONS $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
add_dependencies(program_gl_tests gpvc)

include(${CMAKE_CURRENT_LIST_DIR}/compare.cmake)
