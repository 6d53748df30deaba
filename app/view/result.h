// A textured mesh from a folder, with what the page asks of it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "app/view/drawn_model.h"
#include "app/view/pictures.h"
#include "io/textured_model.h"

namespace gpvc::view {

struct ResultPage {
  std::filesystem::path file;     ///< as it is in the result, or written anew where the model holds it
  std::filesystem::path quarter;  ///< where make_quarter() writes it
  int width = 0, height = 0;
  std::string key;  ///< the same for the same bytes: pages that an edit keeps are not sent again
};

struct Result {
  std::filesystem::path folder, model_file;
  Mesh mesh;                         ///< in its file's coordinates less `offset`
  io::TexturedModel model;           ///< model.mesh is null
  WorldPoint offset;                 ///< to be added to positions
  std::vector<std::uint32_t> face;   ///< per face of the model its number in the mesh that was textured
  std::vector<std::int32_t> labels;  ///< per face of the model its photo, -1 for none; empty: unknown
  std::vector<std::uint8_t> tags;    ///< per face of the model; empty: unknown
  std::vector<ResultPage> pages;
};

/// Reads the model of a result, or a model by its file; of pages that are files the sizes alone. Throws InputError, OutputError.
Result read_result(const std::filesystem::path& from, const ScratchFolder& scratch);

/// Writes a JPEG of a quarter of the page's width and height; again does nothing. Throws InputError, OutputError.
void make_quarter(const ResultPage& page);

/// "image/jpeg"; by the file's first bytes.
std::string media_type(const std::filesystem::path& image);

}  // namespace gpvc::view
