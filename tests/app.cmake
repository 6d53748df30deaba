gpvc_test(city_test gpvc_app)
gpvc_test(modes_texture_gl_test gpvc_app)
gpvc_test(scene_writer_test gpvc_app)
gpvc_test(synth_test gpvc_app)
gpvc_test(truth_test gpvc_app)
gpvc_test(frame_check_test gpvc_app)

# The program itself, on a small scene that it makes once.
if(EXISTS ${CMAKE_CURRENT_SOURCE_DIR}/app_test.cpp)
  set(app_scene ${CMAKE_CURRENT_BINARY_DIR}/app_scene)
  add_test(NAME app_scene.synth COMMAND gpvc synth city -o ${app_scene} --faces 5000 --size 50 --photos 5
                                        --photo-size 240x160 --force --quiet)
  set_tests_properties(app_scene.synth PROPERTIES FIXTURES_SETUP app_scene LABELS gpu)
  add_executable(app_test app_test.cpp app_evaluate_test.cpp app_input_test.cpp app_output_test.cpp)
  target_link_libraries(app_test PRIVATE gpvc_app gpvc_options GTest::gtest_main)
  target_compile_definitions(app_test PRIVATE GPVC_BINARY="$<TARGET_FILE:gpvc>" GPVC_APP_SCENE="${app_scene}")
  add_dependencies(app_test gpvc)
  gtest_discover_tests(app_test DISCOVERY_TIMEOUT 60
    PROPERTIES LABELS gpu TIMEOUT 600 FIXTURES_REQUIRED app_scene)
endif()

# gpvc visibility on that scene.
add_executable(visibility_command_test visibility_command_test.cpp)
target_link_libraries(visibility_command_test PRIVATE gpvc_app gpvc_options GTest::gtest_main)
target_compile_definitions(visibility_command_test PRIVATE GPVC_BINARY="$<TARGET_FILE:gpvc>"
                                                           GPVC_APP_SCENE="${app_scene}")
add_dependencies(visibility_command_test gpvc)
gtest_discover_tests(visibility_command_test DISCOVERY_TIMEOUT 60
  PROPERTIES LABELS gpu TIMEOUT 600 FIXTURES_REQUIRED app_scene)

include(${CMAKE_CURRENT_LIST_DIR}/compare.cmake)
