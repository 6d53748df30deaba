// A textured model without its pages, for those who look at them later, or hand the files on.
#pragma once

#include <filesystem>
#include <vector>

#include "textured_model.h"

namespace gpvc::io {

/// As read_textured_model(), but pages that are files beside an OBJ or PLY are not decoded: `files` gets their paths, by number. The
/// pages of a glTF go to `take_page`, and `files` stays empty. Throws InputError.
LoadedModel read_model_pages(const std::filesystem::path& file, const TakePage& take_page,
                             std::vector<std::filesystem::path>& files);

}  // namespace gpvc::io
