#include "app/python/uv.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "app/python/worker.h"

namespace gpvc::python {
namespace {

using io::StatedUv;
using Coordinates = py::array_t<double, py::array::c_style>;
using Indices = py::array_t<std::uint32_t, py::array::c_style>;

// Arrays have v downwards, as pages do, and files of OBJ upwards.
std::array<double, 2> turned(const double* uv) { return {uv[0], 1 - uv[1]}; }

// uv: (F, 3, 2) or (V, 2); page: (F,), StatedUv::kNone for faces without coordinates.
MeshUv of_arrays(const Coordinates& uv, const Indices& faces, const Indices& page,
                 const std::vector<std::tuple<std::string, int, int>>& pages) {
  MeshUv made{{}, "uv"};
  StatedUv& stated = made.stated;
  stated.face_texcoords.resize(static_cast<std::size_t>(faces.shape(0)));
  if (uv.ndim() == 3) {
    std::vector<Triangle> triangles(stated.face_texcoords.size());
    std::copy_n(faces.data(), faces.size(), triangles.data()->data());
    std::vector<std::array<double, 2>> corners;
    for (py::ssize_t n = 0; n < uv.size(); n += 2) corners.push_back(turned(uv.data() + n));
    io::set_corners(triangles, corners, stated);
  } else {
    for (py::ssize_t vertex = 0; vertex < uv.shape(0); ++vertex)
      stated.texcoords.push_back(turned(uv.data() + 2 * vertex));
    std::copy_n(faces.data(), faces.size(), stated.face_texcoords.data()->data());
  }
  stated.face_material.assign(page.data(), page.data() + page.size());
  for (std::size_t face = 0; face < stated.face_texcoords.size(); ++face)
    if (stated.face_material[face] == StatedUv::kNone) stated.face_texcoords[face].fill(StatedUv::kNone);
  for (const auto& [name, width, height] : pages) stated.materials.push_back({name, width, height});
  return made;
}

std::shared_ptr<MeshUv> of_file(const std::string& model) {
  const auto made = std::make_shared<MeshUv>();
  made->name = model;
  Worker().call([=] { made->stated = io::read_uv(model); }, cancel_flag());
  return made;
}

Coordinates coordinates(const MeshUv& uv) {
  const StatedUv& stated = uv.stated;
  Coordinates all({static_cast<py::ssize_t>(stated.face_texcoords.size()), py::ssize_t{3}, py::ssize_t{2}});
  double* to = all.mutable_data();
  for (const Triangle& corners : stated.face_texcoords)
    for (const std::uint32_t corner : corners) {
      const bool has_any = corner < stated.texcoords.size();
      *to++ = has_any ? stated.texcoords[corner][0] : std::numeric_limits<double>::quiet_NaN();
      *to++ = has_any ? 1 - stated.texcoords[corner][1] : std::numeric_limits<double>::quiet_NaN();
    }
  return all;
}

// Faces without a material lie on a page of their own behind the others; -1: they have no coordinates.
py::array_t<std::int32_t> pages_of_faces(const MeshUv& uv) {
  const StatedUv& stated = uv.stated;
  py::array_t<std::int32_t> all(static_cast<py::ssize_t>(stated.face_texcoords.size()));
  std::int32_t* to = all.mutable_data();
  for (std::size_t face = 0; face < stated.face_texcoords.size(); ++face) {
    const bool has_any = std::ranges::all_of(stated.face_texcoords[face],
                                             [&](std::uint32_t corner) { return corner < stated.texcoords.size(); });
    const std::uint32_t material = stated.face_material.empty() ? StatedUv::kNone : stated.face_material[face];
    *to++ = has_any ? static_cast<std::int32_t>(std::min<std::size_t>(material, stated.materials.size())) : -1;
  }
  return all;
}

}  // namespace

void bind_uv(py::module_& module) {
  py::class_<MeshUv, std::shared_ptr<MeshUv>>(module, "MeshUv")
      .def_static("of_arrays", &of_arrays)
      .def_static("of_file", &of_file)
      .def("uv", &coordinates)
      .def("page", &pages_of_faces)
      .def("pages",
           [](const MeshUv& uv) {
             py::list all;
             for (const io::StatedUv::Material& page : uv.stated.materials)
               all.append(py::make_tuple(page.name, page.width, page.height));
             return all;
           })
      .def_property_readonly("faces", [](const MeshUv& uv) { return uv.stated.face_texcoords.size(); });
}

}  // namespace gpvc::python
