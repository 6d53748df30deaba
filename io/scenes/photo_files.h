// Which file on disk is which photo of a scene.
#pragma once

#include <filesystem>
#include <vector>

#include "io/scene_files.h"
#include "io/scenes/scene_file.h"

namespace gpvc::io {

/// Turns names that are whole paths into names relative to the folder they share, and keeps an absolute one as the path
/// that the file states; orders views by name. Throws InputError when two are the same.
void normalize_names(SceneFile& scene);

/// Sets View::photo, empty where there is none. Looked at in this order: the path that the file states (unless
/// SceneOptions::images_dir is given), the view's name below the folder of the photos where that is all of the path
/// stated, and the files in and under that folder by the longest common tail of their paths: as it stands, then in any
/// case of letters, then, for a name without an image's extension, with any, raw files last. Of several with the same
/// tail the one at the view's name below the folder is taken. A file that is found for several views is that of the
/// view it was stated for, or whose path has the longest tail in common with it, be that view `needed` (one flag each)
/// or not; the others are without. Where this tells nothing, a needed view goes before those that are not, with a
/// warning. Missing photos and those of which several files share the longest tail are noted (forget_photo). Throws
/// InputError when no folder is found, and when two needed photos are one file. Returns the folder searched last.
std::filesystem::path find_photos(SceneFile& scene, const std::vector<bool>& needed, const SceneOptions& options);

/// Texture layers that RealityCapture keeps beside photos take their place, with a warning: they are the same pictures with
/// the colours that the model is to have.
void use_texture_layers(SceneFile& scene);

/// Reads the size of every photo found and fits its camera to it: cameras without a size get their pixels, cameras
/// calibrated at another size of the same shape are scaled, and a photo that cannot be read or is of another shape is
/// forgotten (forget_photo).
void fit_cameras(SceneFile& scene, const std::vector<bool>& needed);

}  // namespace gpvc::io
