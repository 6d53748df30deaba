// Geometry of GLBs compressed without loss: EXT_meshopt_compression, which CesiumJS, three.js (with its decoder) and others read.
// https://github.com/KhronosGroup/glTF/tree/main/extensions/2.0/Vendor/EXT_meshopt_compression
#pragma once

#include <filesystem>

namespace gpvc::tileset {

/// Replaces a GLB that write_gltf() has written by one with the same values, triangle by triangle; a triangle may begin with
/// another of its corners. Throws InputError where the file is no such GLB, OutputError.
void compress_geometry(const std::filesystem::path& glb);

}  // namespace gpvc::tileset
