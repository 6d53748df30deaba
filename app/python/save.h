// The files of a result.
#pragma once

#include <filesystem>

#include "app/python/texture.h"

namespace gpvc::python {

/// Writes NAME.glb or NAME.gltf; NAME.obj with NAME.mtl, its pages NAME_0.jpg and so on and, where coordinates are large,
/// offset.txt; or, of a path without such an ending, the folder that `gpvc texture` writes. The bytes of model.glb, model.obj and
/// their pages are the program's. Files appear when all are complete, pages first and the model last.
/// A folder must hold no result; files are replaced. Throws OutputError.
void save(const TextureResult& result, const std::filesystem::path& path, results::Observer& observer);

}  // namespace gpvc::python
