#include "app/python/errors.h"

#include <exception>

#include "app/python/python.h"
#include "app/results/observer.h"

namespace gpvc::python {
namespace {

// Empty: nothing that the module offers.
std::string clause_of(Cure cure) {
  switch (cure) {
    case Cure::keep_odd_views:
      return "keep_odd_photos=True textures with them all the same";
    case Cure::allow_misfit:
      return "allow_misfit=True textures all the same";
    case Cure::allow_unseen:
      return "allow_unseen=True textures all the same";
    case Cure::name_mesh_crs:
      return "name the mesh's reference system by mesh_crs='EPSG:NUMBER'";
    case Cure::more_memory:
      return "free some, or allow another amount by memory='4G'";
    case Cure::limit_memory:
      return "keep it below an amount by memory='4G'";
    case Cure::skip_bad_photos:
      return "skip_bad_photos=True of read_scene() goes on without them";
    case Cure::keep_background:
      return "background='none' keeps them";
    case Cure::photos_folder:
      return "name the folder of the photos by images= of read_scene()";
    case Cure::smaller_photos:
      return "lower what it needs by smaller images, or downscale=2 of read_scene()";
    case Cure::fewer_views:
      return "texture from fewer views=";
    case Cure::fewer_faces:
      return "take a mesh of fewer faces";
    case Cure::more_bytes:
      return "allow more by max_bytes=";
    case Cure::bands_as_tiff:
      return "take TIFFs for them by band_format='tif'";
    case Cure::other_folder:
      return "choose another path";
    case Cure::replace_result:
    case Cure::look_at_fit:
    case Cure::make_editable:
    case Cure::make_job:
    case Cure::smaller_tiles:
    case Cure::fewer_unit_views:
    case Cure::synthesize:
      return {};
  }
  return {};
}

void raise(const char* type, const Error& error) {
  const std::string sentence = results::printable(error.what());  // paths may hold bytes that are no UTF-8
  const py::object made = py::module_::import("gpvc._errors").attr(type)(with_arguments(sentence, error.cures()));
  py::dict measures;
  for (const Measure& measure : error.measures()) measures[py::str(measure.name)] = measure.value;
  made.attr("measures") = measures;
  PyErr_SetObject(reinterpret_cast<PyObject*>(Py_TYPE(made.ptr())), made.ptr());
}

}  // namespace

std::string with_arguments(const std::string& sentence, std::span<const Cure> cures) {
  std::string advice;
  for (const Cure cure : cures) {
    const std::string clause = clause_of(cure);
    if (!clause.empty()) advice += (advice.empty() ? "" : ", or ") + clause;
  }
  if (advice.empty()) return sentence;
  return sentence + (sentence.ends_with('?') ? " " : "; ") + advice;
}

void register_errors() {
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const InputError& error) {
      raise("InputError", error);
    } catch (const OutputError& error) {
      raise("OutputError", error);
    } catch (const Error& error) {
      raise("Error", error);
    }
  });
}

}  // namespace gpvc::python
