// What a run is asked to do.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "../../atlas/atlas.h"
#include "../../io/images.h"
#include "../../io/names.h"
#include "../../io/textured_model.h"
#include "../../labeling/labeling.h"
#include "../../visibility/method.h"
#include "view_rules.h"

namespace gpvc::pipeline {

/// The viewers that model.glb is written for. full: all of them, and programs that edit it. web: browsers, which get a small file
/// (io::GltfCoding::quantized, web_model.h). model.obj is the same for both. with_target() sets the limits of bytes and pages.
enum class Target { full, web };
inline constexpr Named<Target> kTargetNames[] = {{"full", Target::full}, {"web", Target::web}};

/// What a model for the web takes at most unless it is told otherwise: what WebODM's viewer loads.
inline constexpr std::size_t kWebBytes = 150'000'000;

/// The formats of pages beside an OBJ.
inline constexpr Named<io::ImageFormat> kPageFormatNames[] = {{"jpg", io::ImageFormat::jpg},
                                                              {"png", io::ImageFormat::png}};

struct OutputSettings {
  Target target = Target::full;
  std::size_t max_bytes = 0;  ///< for the web: of model.glb, or of its parts without fallbacks; 0: kWebBytes
  int webp_quality = 85;      ///< of pages for the web
  bool jpeg_fallback = true;  ///< pages for the web have one, for readers without WebP
  io::ImageFormat texture = io::ImageFormat::jpg;
  int quality = 95;                                      ///< of JPEG pages
  io::SampleFormat band_format = io::SampleFormat::tif;  ///< of the samples beside pages, where photos have bands
  io::GltfContainer gltf = io::GltfContainer::glb;
  bool normals = false;
  bool lit = false;              ///< io::ModelOptions::lit
  std::optional<io::UpAxis> up;  ///< nullopt: found from the cameras
};

/// Where faces of a given layout lie over each other. once: each texel shows one of them, and a warning counts them. refuse: the
/// run ends before photos are looked at.
enum class Overlap { once, refuse };
inline constexpr Named<Overlap> kOverlapNames[] = {{"once", Overlap::once}, {"refuse", Overlap::refuse}};

/// Whether texture_into() keeps its work in the output folder until the result is complete, so that it can go on from there
/// after it was cut off. automatic: if it is expected to take more than a minute, or an earlier run has kept some.
enum class KeepWork { automatic, always, never };
inline constexpr Named<KeepWork> kKeepWorkNames[] = {
    {"auto", KeepWork::automatic}, {"always", KeepWork::always}, {"never", KeepWork::never}};

struct Settings {
  visibility::VisibilityOptions visibility;
  int device = -1;  ///< number of the graphics device to use; -1: see visibility::find_device()
  labeling::CostOptions costs;
  bool allow_misfit = false;              ///< texture a scene whose mesh, poses and photos contradict each other
  bool allow_unseen = false;              ///< texture a mesh of which photos see less than checks::kLeastSeen
  std::vector<ViewRule> view_rules = {};  ///< faces in their regions lose the views that they refuse
  labeling::EdgeWeights edge_weights = labeling::EdgeWeights::uniform;
  labeling::SolverOptions solver;
  atlas::AtlasOptions atlas;
  OutputSettings output;
  /// Most bytes that texture() and texture_into() take; 0: see plan_memory(). Results are the same for any value.
  std::size_t memory_bytes = 0;
  KeepWork keep_work = KeepWork::automatic;
  /// texture_into() also writes what retexture_into() needs to change the result (edit_files.h).
  bool editable = false;
  Overlap overlap = Overlap::once;  ///< of Input::layout
};

}  // namespace gpvc::pipeline
