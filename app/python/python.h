// What the sources of the module share: pybind11, and its NumPy arrays.
#pragma once

// Headers of others, which are not written for our warnings.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wshadow"
#pragma GCC diagnostic ignored "-Wconversion"
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#pragma GCC diagnostic pop

#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

namespace gpvc::python {

namespace py = pybind11;

/// Keeps a Python object alive from C++ threads: it is let go with the interpreter's lock held.
inline std::shared_ptr<const py::object> shared_object(py::object object) {
  return {new py::object(std::move(object)), [](const py::object* last) {
            const py::gil_scoped_acquire lock;
            delete last;
          }};
}

/// An array over the memory of a vector, which it takes over.
template <typename To, typename From>
py::array_t<To> array_over(std::vector<From> values, std::vector<py::ssize_t> shape) {
  static_assert(sizeof(From) % sizeof(To) == 0);
  auto* held = new std::vector<From>(std::move(values));
  const py::capsule owner(held, [](void* vector) { delete static_cast<std::vector<From>*>(vector); });
  return py::array_t<To>(std::move(shape), reinterpret_cast<const To*>(held->data()), owner);
}

/// An array over memory that `keeper` keeps, which must not be written to.
template <typename To>
py::array_t<To> read_only_array(const To* values, std::vector<py::ssize_t> shape, std::shared_ptr<const void> keeper) {
  auto* held = new std::shared_ptr<const void>(std::move(keeper));
  const py::capsule owner(held, [](void* kept) { delete static_cast<std::shared_ptr<const void>*>(kept); });
  py::array_t<To> array(std::move(shape), values, owner);
  array.attr("flags").attr("writeable") = false;
  return array;
}

}  // namespace gpvc::python
