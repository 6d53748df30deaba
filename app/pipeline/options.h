// The options of a run: one list for each struct of settings, from which the keys of kept work, run.json, job.json, the command
// line and its help follow. An option is a member of its struct and an entry here.
#pragma once

#include <concepts>
#include <cstddef>
#include <optional>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "../../io/members.h"
#include "../../io/names.h"
#include "../../io/scene_members.h"
#include "../../io/work_store.h"
#include "settings.h"

namespace gpvc::visibility {
GPVC_MEMBERS(Gpvc, sampling, drawing, classifier)
GPVC_MEMBERS(PaperGpvc, sampling, projection, correction, classifier)
GPVC_MEMBERS(ShadowMap, projection, epsilon)
GPVC_MEMBERS(RayTracing, sampling, epsilon, drawing)
GPVC_MEMBERS(NoTest, drawing)
GPVC_MEMBERS(VisibilityOptions, method, subpixel, draw_ivm)
}  // namespace gpvc::visibility

namespace gpvc::labeling {
GPVC_MEMBERS(CostOptions, term, outliers, background, data_weight, margin_px, margin_cost, coarse_cost, keep_odd_views,
             hidden_cost)
GPVC_MEMBERS(SolverOptions, smoothness, max_sweeps, thorough, small_patch_faces, small_patch_rise)
}  // namespace gpvc::labeling

namespace gpvc::atlas {
GPVC_MEMBERS(AtlasOptions, page_size, padding, align, seams, band_gains, blend, blend_cost, margin_px, texel_size,
             max_pages, max_texels, unseen, unseen_color)
}  // namespace gpvc::atlas

namespace gpvc::pipeline {
GPVC_MEMBERS(ViewRule, region, allow, views, name)
GPVC_MEMBERS(OutputSettings, target, max_bytes, webp_quality, jpeg_fallback, texture, quality, band_format, gltf,
             normals, lit, up)
GPVC_MEMBERS(Settings, visibility, device, costs, allow_misfit, allow_unseen, view_rules, edge_weights, solver, atlas,
             output, memory_bytes, keep_work, editable, overlap)

/// The first result that depends on an option; so do all later ones. pages: as photos have painted them; page_files: filled and
/// encoded; nothing: results are the same.
enum class Affects { views, labels, pages, page_files, models, nothing };

/// The results that an option is for: all; those of one process, which jobs are not; those that are one model.
enum class For { all, one_process, one_model };

inline constexpr std::string_view kBytes = "SIZE";  ///< the kind of an amount of bytes

struct OptionInfo {
  const char* name;  ///< "page-size"
  Affects affects;
  For result = For::all;
  const char* group = nullptr;  ///< heading of the help; null: not offered
  const char* kind = "";        ///< of a number: "PX"
  double least = 0, most = 0;   ///< of a number
  const char* help = "";
  const char* unset = "";                            ///< of an amount of bytes: what is taken where none is given
  bool is_amount() const { return kind == kBytes; }  // texts are compared: the same literal may lie at several places
};

template <typename Value>
struct Option {
  Value& value;
  OptionInfo info;
};

/// Of an optional axis; none: found from the cameras.
inline constexpr Named<std::optional<io::UpAxis>> kUps[] = {
    {"auto", std::nullopt},    {"+x", io::UpAxis::pos_x}, {"-x", io::UpAxis::neg_x}, {"+y", io::UpAxis::pos_y},
    {"-y", io::UpAxis::neg_y}, {"+z", io::UpAxis::pos_z}, {"-z", io::UpAxis::neg_z}};

// The names of an option's values.
constexpr const auto& names_of(labeling::DataTerm) { return labeling::kDataTermNames; }
constexpr const auto& names_of(labeling::Outliers) { return labeling::kOutliersNames; }
constexpr const auto& names_of(labeling::Background) { return labeling::kBackgroundNames; }
constexpr const auto& names_of(labeling::EdgeWeights) { return labeling::kEdgeWeightsNames; }
constexpr const auto& names_of(atlas::PhotoAlignment) { return atlas::kPhotoAlignmentNames; }
constexpr const auto& names_of(atlas::SeamLeveling) { return atlas::kSeamLevelingNames; }
constexpr const auto& names_of(atlas::Blending) { return atlas::kBlendingNames; }
constexpr const auto& names_of(atlas::UnseenFaces) { return atlas::kUnseenFacesNames; }
constexpr const auto& names_of(Target) { return kTargetNames; }
constexpr const auto& names_of(io::ImageFormat) { return kPageFormatNames; }
constexpr const auto& names_of(io::SampleFormat) { return io::kSampleFormatNames; }
constexpr const auto& names_of(io::GltfContainer) { return io::kGltfContainerNames; }
constexpr const auto& names_of(KeepWork) { return kKeepWorkNames; }
constexpr const auto& names_of(Overlap) { return kOverlapNames; }
constexpr const auto& names_of(const std::optional<io::UpAxis>&) { return kUps; }

template <typename Value>
concept IsNamed = requires(const Value& value) {
  names_of(value);
};

// The headings of the help, by need.
inline constexpr const char* kInput = "Input";
inline constexpr const char* kQuality = "Quality";
inline constexpr const char* kSize = "Size";
inline constexpr const char* kOutput = "Output";
inline constexpr const char* kMachine = "Machine";
inline constexpr const char* kResearch = "Research";
inline constexpr double kMostCost = 1e6;  ///< where two neighbouring faces with different views cost 1

/// An option that is not offered. Of a number the least and the most.
template <typename Value>
Option<Value> hidden(Value& value, const char* name, Affects affects, double least = 0, double most = 0) {
  return {value, {name, affects, For::all, nullptr, "", least, most}};
}
/// A flag, or one of the names of an enum.
template <typename Value>
Option<Value> offered(Value& value, const char* name, Affects affects, const char* group, const char* help) {
  return {value, {name, affects, For::all, group, "", 0, 0, help}};
}
template <typename Value>
Option<Value> number(Value& value, const char* name, Affects affects, const char* group, const char* kind, double least,
                     double most, const char* help) {
  return {value, {name, affects, For::all, group, kind, least, most, help}};
}
/// A text, whose kind the help names.
template <typename Value>
Option<Value> text(Value& value, const char* name, Affects affects, const char* group, const char* kind,
                   const char* help) {
  return {value, {name, affects, For::all, group, kind, 0, 0, help}};
}
/// An amount of bytes. \param unset what is taken where none is given
template <typename Value>
Option<Value> amount(Value& value, const char* name, Affects affects, const char* group, const char* unset,
                     const char* help) {
  return {value, {name, affects, For::all, group, kBytes.data(), 0, 0, help, unset}};
}
template <typename Value>
Option<Value> only(For result, Option<Value> option) {
  option.info.result = result;
  return option;
}

template <io::Like<visibility::VisibilityOptions> T>
auto options_of(T& o) {
  using enum Affects;
  return std::tuple(offered(o.method, "visibility", views, kResearch, ""),
                    offered(o.subpixel, "subpixel", views, kResearch, "Leave faces smaller than a pixel unresolved"),
                    hidden(o.draw_ivm, "draw-ivm", views));
}

template <io::Like<labeling::CostOptions> T>
auto options_of(T& o) {
  using enum Affects;
  return std::tuple(
      offered(
          o.term, "data-term", views, kResearch,
          "What makes a photo good for a face. area: its pixels; gmi: the image gradient summed over them; -angle: the "
          "same times the squared cosine of the viewing angle; nadir: how far it looks straight down (against z)"),
      offered(o.outliers, "outliers", labels, kQuality,
              "Photos whose colour of a face differs from the others' (cars, people). clamp: not used there; damp: "
              "used less; none: used"),
      offered(o.background, "background", views, kQuality,
              "Sky behind a roof, the uniform backdrop of a turntable, black borders of photos. auto: not used as "
              "texture; faces in whose place most photos show it are not in the GLB (the OBJ keeps every face); none: "
              "taken for the surface"),
      offered(o.keep_odd_views, "keep-odd-photos", labels, kInput,
              "Also use photos that show something else than the others do (as a rule their pose is wrong). By default "
              "they are left out and named"),
      number(
          o.margin_px, "margin", views, kResearch, "PX", 0, 64,
          "Pixels along silhouettes in which a view costs more, as photo and mesh disagree there, 0 to 64; 0 is off"),
      hidden(o.data_weight, "data-weight", labels, 0, kMostCost),
      hidden(o.margin_cost, "margin-cost", labels, 0, kMostCost),
      hidden(o.coarse_cost, "coarse-cost", labels, 0, kMostCost),
      hidden(o.hidden_cost, "hidden-cost", labels, 0, kMostCost));
}

template <io::Like<labeling::SolverOptions> T>
auto options_of(T& o) {
  using enum Affects;
  return std::tuple(
      number(o.smoothness, "smoothness", labels, kResearch, "X", 0, kMostCost,
             "Cost of a seam between two adjacent faces with different views; 0 or more"),
      offered(o.thorough, "thorough", labels, kResearch,
              "Search the whole mesh for better views until none is found: several times slower, for an energy that is "
              "at most 0.2 % lower"),
      hidden(o.max_sweeps, "max-sweeps", labels, 0, 1e4),
      hidden(o.small_patch_faces, "small-patch-faces", labels, 0, 1e9),
      hidden(o.small_patch_rise, "small-patch-rise", labels, 0, kMostCost));
}

template <io::Like<atlas::AtlasOptions> T>
auto options_of(T& o) {
  using enum Affects;
  return std::tuple(
      number(o.page_size, "page-size", pages, kSize, "N", 256, 32768,
             "Largest edge of a texture page, 256 to 32768 texels"),
      number(o.padding, "padding", pages, kSize, "N", 1, 64,
             "Texels around a chart that repeat its colours, 1 to 64; with 8, mip levels down to an eighth keep charts "
             "apart, with 4 down to a quarter"),
      number(o.texel_size, "texel-size", pages, kSize, "X", 1e-9, 1e9,
             "Smallest edge of a texel, in the mesh's units: charts with finer texels are reduced to it"),
      // How unseen faces are filled is decided after a page is kept.
      offered(
          o.unseen, "unseen", page_files, kQuality,
          "Faces that no photo shows. fill: with the colours around them; drop: not in the GLB (the OBJ keeps every "
          "face); color: in one colour"),
      number(o.unseen_color, "unseen-color", page_files, kQuality, "R,G,B", 0, 255,
             "The colour of unseen faces that get one, 0 to 255 each"),
      offered(
          o.align, "align", pages, kQuality,
          "local: photos are compared with each other, and each is shifted by a pixel or two from place to place so "
          "that lines go on across seams; none: photos lie where poses and lens have them"),
      offered(o.seams, "seams", pages, kQuality,
              "Levelling of colours across seams. global: one correction per chart and vertex; full: that, and a blend "
              "near the seam; none: colours as in the photos"),
      only(For::one_model, offered(o.band_gains, "band-gains", pages, kQuality,
                                   "Multiply bands that are quantities, such as reflectance, by one gain per photo and "
                                   "band, so that photos agree "
                                   "along seams; without, they stay as they are in the photos")),
      offered(
          o.blend, "blend", pages, kQuality,
          "coarse: brightness and colour come in part from all photos that see a place whole, fine detail (up to some "
          "four pixels) from one; none: everything from one photo"),
      only(For::one_model, number(o.max_pages, "max-pages", pages, kSize, "N", 1, 1e6,
                                  "Reduce all charts by one factor to fit on N pages")),
      only(For::one_model,
           number(o.max_texels, "max-texels", pages, kSize, "N", 4096, 1e15,
                  "Reduce all charts by one factor until all pages together have at most N texels, 4096 or more")),
      hidden(o.blend_cost, "blend-cost", pages, 0, kMostCost), hidden(o.margin_px, "partial-margin", pages, 0, 64));
}

template <io::Like<OutputSettings> T>
auto options_of(T& o) {
  using enum Affects;
  return std::tuple(
      offered(
          o.target, "target", models, kOutput,
          "full: GLBs that every viewer opens; web: small ones for browsers. WebP pages (EXT_texture_webp), geometry "
          "quantized to 16 bits and compressed (KHR_mesh_quantization, EXT_meshopt_compression), a model on one page "
          "unless "
          "more are allowed"),
      only(For::one_model,
           amount(o.max_bytes, "max-bytes", models, kOutput, "150M",
                  "For the web: most bytes of model.glb, as 20M. Texels, and where that is not enough quality, are "
                  "reduced to stay below")),
      number(o.webp_quality, "webp-quality", models, kOutput, "N", 1, 100,
             "For the web: quality of the pages, 1 to 100"),
      offered(o.jpeg_fallback, "jpeg-fallback", models, kOutput,
              "For the web: leave out the JPEGs of a quarter of the pages' width and height that viewers without WebP "
              "take"),
      offered(o.texture, "texture", page_files, kOutput,
              "Format of the pages: jpg is quick to write and load, png is lossless"),
      // Pages of two qualities may be those of one model.
      number(o.quality, "quality", models, kOutput, "N", 1, 100, "JPEG quality of the pages, 1 to 100"),
      offered(o.band_format, "band-format", page_files, kOutput,
              "Format of the bands beside the pages, where photos have more than RGB of 8 bits. tif: model_N.tif; png: "
              "model_N_bands.png, which holds 1 to 4 bands of 8 or 16 bits, and no mask of the texels with a value"),
      only(For::one_model,
           offered(o.gltf, "gltf", models, kOutput,
                   "glb: one file, model.glb; files: model.gltf with model.bin and the pages beside it, which is also "
                   "written for a model beyond the 4 GiB of a GLB")),
      only(For::one_model,
           offered(o.normals, "normals", models, kOutput,
                   "Also write smooth normals, vn in the OBJ and NORMAL in the GLB; without them viewers do not shade "
                   "the model")),
      offered(
          o.lit, "lit", models, kOutput,
          "Let viewers shade the GLB with their lights. By default it looks as in the photos (KHR_materials_unlit)"),
      offered(o.up, "up", models, kOutput,
              "Axis of the scene that points up in the GLB; auto: away from the cameras' mean viewing direction"));
}

template <io::Like<Settings> T>
auto options_of(T& o) {
  using enum Affects;
  return std::tuple_cat(
      options_of(o.visibility), options_of(o.costs), options_of(o.solver), options_of(o.atlas), options_of(o.output),
      std::tuple(
          hidden(o.device, "device", views, -1, 1e4),
          offered(o.allow_misfit, "allow-misfit", nothing, kInput,
                  "Texture although most photos disagree, or the mesh is not where photos or tie points show it. "
                  "Without this the run stops and names the likely mistake"),
          offered(o.allow_unseen, "allow-unseen", nothing, kInput,
                  "Texture although photos see less than 5 % of the faces. Without this the run stops: as a rule the "
                  "mesh is in other coordinates"),
          hidden(o.view_rules, "allow", labels),
          offered(
              o.edge_weights, "edge-weights", labels, kResearch,
              "What a seam's cost is multiplied by: 1, the length of the edge, its flatness (seams are less visible "
              "in folds), or both"),
          amount(o.memory_bytes, "memory", nothing, kMachine, "what the scene needs, 70 % of what is free at most",
                 "Stay below this much memory (600M, 4G). More of it decodes fewer photos twice; the model is the "
                 "same. A scene that does not fit is textured in tiles"),
          only(For::one_process,
               offered(o.keep_work, "resume", nothing, kMachine,
                       "Keep finished work in OUT/.work until all is done, so that the same command goes on from there "
                       "if it is cut off; auto: if it may take more than a minute")),
          only(For::one_model, offered(o.editable, "editable", nothing, kOutput,
                                       "Also keep what it takes to change this result later: three files, edit-*")),
          only(For::one_model, offered(o.overlap, "overlap", nothing, kSize,
                                       "Where faces lie over each other in the texture coordinates of MESH. once: the "
                                       "texels are baked once, for one "
                                       "of the faces; refuse: the run stops"))));
}

namespace detail {
template <typename T>
inline constexpr std::size_t kMembers = std::tuple_size_v<decltype(members_of(std::declval<T&>()))>;
template <typename T>
inline constexpr std::size_t kOptions = std::tuple_size_v<decltype(options_of(std::declval<T&>()))>;
}  // namespace detail

/// True if each member has an option, of those whose types are `Nested` all of theirs. One that is forgotten would let a run go
/// on from work that was done with another value.
template <typename T, typename... Nested>
inline constexpr bool kListsAll = detail::kOptions<T> ==
                                  detail::kMembers<T> - sizeof...(Nested) + (detail::kOptions<Nested> + ... + 0);
static_assert(kListsAll<visibility::VisibilityOptions> && kListsAll<labeling::CostOptions> &&
              kListsAll<labeling::SolverOptions> && kListsAll<atlas::AtlasOptions> && kListsAll<OutputSettings>);
static_assert(kListsAll<Settings, visibility::VisibilityOptions, labeling::CostOptions, labeling::SolverOptions,
                        atlas::AtlasOptions, OutputSettings>);

/// Calls use(value, info) for each option, in the order of the lists.
template <typename T, typename Use>
void for_each_option(T& settings, const Use& use) {
  std::apply([&](const auto&... option) { (use(option.value, option.info), ...); }, options_of(settings));
}

/// True if an option can have the value: one of its names, or a number within its limits. `unset`: what it has where nothing
/// is asked for, which may lie outside of them.
template <typename Value>
bool is_sound(const Value& value, const Value& unset, const OptionInfo& info) {
  if constexpr (IsNamed<Value>) {
    return name_of(names_of(value), value) != nullptr;
  } else if constexpr (std::is_arithmetic_v<Value> && !std::same_as<Value, bool>) {
    const auto number = static_cast<double>(value);
    return value == unset || info.is_amount() || (number >= info.least && number <= info.most);
  } else {
    return true;
  }
}

/// True if all options can have their values; of methods and rules nothing is looked at.
template <typename T>
bool are_sound(const T& settings) {
  const T unset{};
  const auto options = options_of(settings), others = options_of(unset);
  return [&]<std::size_t... n>(std::index_sequence<n...>) {
    return (is_sound(std::get<n>(options).value, std::get<n>(others).value, std::get<n>(options).info) && ...);
  }
  (std::make_index_sequence<std::tuple_size_v<decltype(options)>>());
}

/// Hashes the options on which a result depends, except view_rules.
inline void add_options(io::WorkHash& hash, const Settings& settings, Affects result) {
  for_each_option(settings, [&](const auto& value, const OptionInfo& info) {
    if constexpr (!std::same_as<std::remove_cvref_t<decltype(value)>, std::vector<ViewRule>>)
      if (info.affects <= result) hash.add(value);
  });
}

}  // namespace gpvc::pipeline
