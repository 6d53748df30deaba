// gpvc._gpvc: what the Python package calls. Arguments come checked, and as the types that stand here: gpvc/*.py sees to that.
#include "app/python/coverage.h"
#include "app/python/errors.h"
#include "app/python/evaluate.h"
#include "app/python/python.h"
#include "app/python/scene.h"
#include "app/python/texture.h"
#include "app/python/uv.h"
#include "app/python/visibility.h"
#include "app/python/worker.h"

PYBIND11_MODULE(_gpvc, module) {
  using namespace gpvc::python;
  register_errors();
  bind_scene(module);
  bind_uv(module);
  bind_texture(module);
  bind_visibility(module);
  bind_coverage(module);
  bind_evaluate(module);
  module.attr("__version__") = GPVC_VERSION;
  py::module_::import("atexit").attr("register")(py::cpp_function(&Worker::wait_for_all));
}
