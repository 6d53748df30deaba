// The mistakes that wrong_scenes makes.
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "io/image.h"
#include "io/scene.h"

namespace gpvc {

struct Input {
  Scene scene;
  Mesh mesh;
};

/// Photos that are shown in place of the right ones, by the number of their views.
using OtherPhotos = std::map<std::size_t, Image>;

/// One way to be wrong: moves views among photos or the mesh, or spoils photos.
struct Mistake {
  std::string name;
  std::function<void(Input&)> make = [](Input&) {};
  /// Image lists say where photos show tie points, as they do until photos or poses are mixed up.
  bool keeps_sightings = false;
  std::function<OtherPhotos(const Input&)> photos = {};
};

/// The longest edge of its bounding box.
double extent_of(const Mesh& mesh);

std::vector<Mistake> mistakes_of_views();
std::vector<Mistake> mistakes_of_meshes();
std::vector<Mistake> mistakes_of_photos();

}  // namespace gpvc
