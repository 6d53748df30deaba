// The materials of an OBJ, from its MTL files.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace gpvc::io {

struct ObjMaterial {
  std::string name, image;  ///< no image: empty
  bool clamped = false;     ///< the image does not repeat
};

/// Of all libraries that the OBJ names and that are there, in their order. Throws InputError.
std::vector<ObjMaterial> read_materials(const std::filesystem::path& obj_file,
                                        const std::vector<std::string>& libraries);

/// Where an image lies that a model names: a path of another machine is looked for by its last name beside the model.
std::filesystem::path image_beside(const std::filesystem::path& model, const std::string& name);

}  // namespace gpvc::io
