// Which files hold the bands of a photo.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "io/scene_files.h"
#include "io/scenes/scene_file.h"

namespace gpvc::io {

/// What the name of a band's file says.
struct BandFileName {
  std::string group;       ///< in small letters; the same for all bands of a photo
  int order = 0;           ///< of the bands
  std::string band;        ///< "NIR"; empty: the name has a number alone
  bool by_folder = false;  ///< the folder is what tells the band
};

/// A file of a photo's group.
struct BandMember {
  BandFileName name;
  std::filesystem::path file;
  /// What the name says of the band: its name, or else its number.
  std::string band() const { return name.band.empty() ? std::to_string(name.order) : name.band; }
};

/// The files of folders by group, each folder listed once.
class BandGroups {
 public:
  /// The files beside the photo (of folders named after bands, in those beside its own) that belong to it, with itself, by order; of
  /// several of one order the first by name. Empty unless the photo is named like a band's file.
  std::map<int, BandMember> of(const std::filesystem::path& photo);

 private:
  const std::multimap<std::string, BandMember>& in_folder(const std::filesystem::path& folder);
  std::map<std::filesystem::path, std::multimap<std::string, BandMember>> folders_;
};

/// Why a band's file cannot be one of the photo's, the end of a sentence about the file; empty: it can. Throws InputError.
std::string misfit_of_band(const std::filesystem::path& file, const std::filesystem::path& photo);

/// Of TIFFs: NAME_GRE, _RED, _REG, _NIR (Parrot's Sequoia); NAME_MS_G, _MS_R, _MS_RE, _MS_NIR (DJI's Mavic 3 Multispectral); DJI_0011 to DJI_0015 (its Phantom 4
/// Multispectral); NAME0000_1 to _10 (MicaSense); files of one name in folders Blue, Green, Red, Red Edge, NIR (Sentera), with or without
/// numbers behind that. nullopt for other names.
std::optional<BandFileName> band_file_name(const std::filesystem::path& file);

/// Fills View::band_files of views with a photo, and SceneFile::band_names. By SceneOptions::bands: files with the name of the
/// photo, the extension and the band aside, in and below each folder; the photo comes first unless it is one of them. Else by
/// band_file_name(): the files beside the photos of which no one is a view's photo, if half of the views that need their photo
/// have some, and their own photos are all of one band. Of these, bands of another size or type than the photo's are left out with a warning. A photo without a file of
/// a band is forgotten (forget_photo). Throws InputError for a folder that is none and for a name that is given twice.
void find_band_files(SceneFile& scene, const std::vector<bool>& needed, const SceneOptions& options);

}  // namespace gpvc::io
