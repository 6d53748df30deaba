// Photos of a scene that cannot be used: all of them are told at once.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "io/error.h"
#include "io/scenes/scene_file.h"

namespace gpvc::io {

/// Takes the photo from the view with this number, and notes why if the view needs it.
void forget_photo(SceneFile& scene, std::size_t view, bool needed, BadPhoto::Problem problem,
                  const std::string& reason);

/// An error's sentence without the file that it names first.
std::string reason_of(const InputError& error, const std::filesystem::path& file);

/// Forgets needed photos that end too early (check_photo_end).
void forget_truncated_photos(SceneFile& scene, const std::vector<bool>& needed);

/// Forgets needed photos that cannot be decoded whole. Decodes all that are needed, on all threads.
void forget_damaged_photos(SceneFile& scene, const std::vector<bool>& needed);

/// One InputError about all SceneFile::bad_photos, if there are any: how many of each kind, and their names. `folder`: where
/// the missing ones were looked for. \param skip they are left out, with a warning, unless none is left of those needed;
/// their views are no longer needed
void refuse_bad_photos(SceneFile& scene, std::vector<bool>& needed, const std::filesystem::path& folder, bool skip);

}  // namespace gpvc::io
