gpvc_test(compare_test gpvc_cli)

# `gpvc compare` on app_test's scene, and its page in headless Chromium.
find_program(GPVC_NODE node)
find_program(GPVC_CHROMIUM chromium)
set(compared ${CMAKE_CURRENT_BINARY_DIR}/compared)
add_test(NAME compare.scene
         COMMAND gpvc compare ${app_scene}/colmap ${app_scene}/mesh.ply -o ${compared} --force --quiet --keep-models
                 --modes none,shadow-map:spc,gpvc:uncorrected,gpvc --eps 1e-5,1e-2 --hold-out 5 --oracle-views 2
                 --crops 4 --reduction 1)
add_test(NAME compare.external
         COMMAND gpvc compare ${app_scene}/colmap ${app_scene}/mesh.ply -o ${compared}/external --force --quiet
                 --modes none --external again=${compared}/modes/gpvc/model.obj --hold-out 5 --oracle-views 0
                 --crops 0 --reduction 1)
add_test(NAME compare.summary
         COMMAND gpvc compare --summarize ${compared}/report.json -o ${compared}/summary --force)
set_tests_properties(compare.scene PROPERTIES FIXTURES_REQUIRED app_scene FIXTURES_SETUP compared LABELS "gpu;app" TIMEOUT 600)
set_tests_properties(compare.external PROPERTIES FIXTURES_REQUIRED "app_scene;compared" FIXTURES_SETUP compared_external
                     LABELS "gpu;app" TIMEOUT 600)
set_tests_properties(compare.summary PROPERTIES FIXTURES_REQUIRED compared
                     PASS_REGULAR_EXPRESSION "percentage points of gpvc on all of app_scene" LABELS app)
if(GPVC_NODE AND GPVC_CHROMIUM)
  add_test(NAME browser.report COMMAND ${GPVC_NODE} ${CMAKE_CURRENT_SOURCE_DIR}/../browser/report_browser.mjs ${compared}
                                       ${CMAKE_CURRENT_BINARY_DIR}/report_browser ${compared}/external)
  set_tests_properties(browser.report PROPERTIES FIXTURES_REQUIRED "compared;compared_external" LABELS "browser;app;nightly"
                       ENVIRONMENT "CHROMIUM=${GPVC_CHROMIUM}" TIMEOUT 600)
endif()
