// The options of a run: one list for each struct of settings, from which the keys of kept work, run.json, job.json, the command
// line and its help follow. An option is a member of its struct and an entry here.
#pragma once

#include <concepts>
#include <cstddef>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "../../io/members.h"
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
GPVC_MEMBERS(CostOptions, term, outliers, data_weight, margin_px, margin_cost, coarse_cost, keep_views, hidden_cost)
GPVC_MEMBERS(SolverOptions, smoothness, max_sweeps, thorough, small_patch_faces, small_patch_rise)
}  // namespace gpvc::labeling

namespace gpvc::atlas {
GPVC_MEMBERS(AtlasOptions, page_size, padding, seams, blend, blend_cost, margin_px, texel_size, max_pages, max_texels,
             unseen, unseen_color)
}  // namespace gpvc::atlas

namespace gpvc::pipeline {
GPVC_MEMBERS(ViewRule, region, allow, views, name)
GPVC_MEMBERS(OutputSettings, texture, quality, gltf, normals, up)
GPVC_MEMBERS(Settings, visibility, device, costs, allow_unseen, view_rules, edge_weights, solver, atlas, output,
             memory_bytes, keep_work, editable)

/// The first result that depends on an option; so do all later ones. pages: as photos have painted them; page_files: filled and
/// encoded; nothing: results are the same.
enum class Affects { views, labels, pages, page_files, models, nothing };

/// The results that an option is for: all; those of one process, which jobs are not; those that are one model.
enum class For { all, one_process, one_model };

struct OptionInfo {
  const char* name;  ///< "page-size"
  Affects affects;
  For result = For::all;
  const char* group = nullptr;  ///< heading of the help; null: not offered
  const char* kind = "";        ///< of a number: "PX"
  double least = 0, most = 0;   ///< of a number
  const char* help = "";
};

template <typename Value>
struct Option {
  Value& value;
  OptionInfo info;
};
template <typename Value>
Option(Value&, OptionInfo) -> Option<Value>;

inline constexpr const char* kChoosing = "View selection";
inline constexpr const char* kTexture = "Texture";
inline constexpr const char* kVisibility = "Visibility";
inline constexpr const char* kMachine = "Common";
inline constexpr const char* kBytes = "SIZE";  ///< the kind of an amount of memory
inline constexpr const char* kChanging = "Changing a result";

template <io::Like<visibility::VisibilityOptions> T>
auto options_of(T& o) {
  using enum Affects;
  return std::tuple(Option(o.method, {.name = "visibility", .affects = views, .group = kVisibility}),
                    Option(o.subpixel, {.name = "subpixel",
                                        .affects = views,
                                        .group = kVisibility,
                                        .help = "Do not resolve faces smaller than a pixel"}),
                    Option(o.draw_ivm, {.name = "draw-ivm", .affects = views}));
}

template <io::Like<labeling::CostOptions> T>
auto options_of(T& o) {
  using enum Affects;
  return std::tuple(
      Option(o.term, {.name = "data-term",
                      .affects = views,
                      .group = kChoosing,
                      .help = "What makes a view good for a face: its area in pixels or the image gradient integrated "
                              "over it, alone or "
                              "times the squared cosine of the viewing angle"}),
      Option(o.outliers, {.name = "outliers",
                          .affects = labels,
                          .group = kChoosing,
                          .help = "Views that disagree in colour with the others (cars, people): keep them, raise "
                                  "their cost, or drop them"}),
      Option(
          o.keep_views,
          {.name = "keep-views",
           .affects = labels,
           .group = kChoosing,
           .help =
               "Use photos that agree with the others no better than chance; by default they are left out, and a scene "
               "where most are such, or whose mesh is not where the photos show it, is refused"}),
      Option(o.margin_px, {.name = "margin",
                           .affects = views,
                           .group = kChoosing,
                           .kind = "PX",
                           .least = 0,
                           .most = 64,
                           .help = "Pixels along silhouettes in which a view costs more, as photo and mesh disagree "
                                   "there, 0 to 64; 0 is off"}),
      Option(o.data_weight, {.name = "data-weight", .affects = labels}),
      Option(o.margin_cost, {.name = "margin-cost", .affects = labels}),
      Option(o.coarse_cost, {.name = "coarse-cost", .affects = labels}),
      Option(o.hidden_cost, {.name = "hidden-cost", .affects = labels}));
}

template <io::Like<labeling::SolverOptions> T>
auto options_of(T& o) {
  using enum Affects;
  return std::tuple(
      Option(o.smoothness, {.name = "smoothness",
                            .affects = labels,
                            .group = kChoosing,
                            .kind = "X",
                            .least = 0,
                            .most = 1e6,
                            .help = "Cost of a seam between two adjacent faces with different views; 0 or more"}),
      Option(o.thorough, {.name = "thorough",
                          .affects = labels,
                          .group = kChoosing,
                          .help = "Search the whole mesh for better views until none is found: several times slower, "
                                  "for an energy that is at most "
                                  "0.2 % lower"}),
      Option(o.max_sweeps, {.name = "max-sweeps", .affects = labels}),
      Option(o.small_patch_faces, {.name = "small-patch-faces", .affects = labels}),
      Option(o.small_patch_rise, {.name = "small-patch-rise", .affects = labels}));
}

template <io::Like<atlas::AtlasOptions> T>
auto options_of(T& o) {
  using enum Affects;
  return std::tuple(
      Option(o.page_size, {.name = "page-size",
                           .affects = pages,
                           .group = kTexture,
                           .kind = "N",
                           .least = 256,
                           .most = 32768,
                           .help = "Largest edge of a texture page, 256 to 32768 texels"}),
      Option(o.padding, {.name = "padding",
                         .affects = pages,
                         .group = kTexture,
                         .kind = "N",
                         .least = 1,
                         .most = 64,
                         .help = "Texels around a chart that repeat its colours, 1 to 64; with 8, mip levels down to "
                                 "an eighth keep charts "
                                 "apart, with 4 down to a quarter"}),
      Option(o.texel_size,
             {.name = "texel-size",
              .affects = pages,
              .group = kTexture,
              .kind = "X",
              .least = 1e-9,
              .most = 1e9,
              .help = "Smallest edge of a texel, in the mesh's units: charts with finer texels are reduced to it"}),
      // How unseen faces are filled is decided after a page is kept.
      Option(o.unseen, {.name = "unseen",
                        .affects = page_files,
                        .group = kTexture,
                        .help = "Faces that no photo shows: fill continues the colours around them, drop leaves them "
                                "out of the GLB (the "
                                "OBJ keeps every face), color gives them one colour"}),
      Option(o.unseen_color, {.name = "unseen-color",
                              .affects = page_files,
                              .group = kTexture,
                              .kind = "R,G,B",
                              .least = 0,
                              .most = 255,
                              .help = "The colour of unseen faces that get one, 0 to 255 each"}),
      Option(
          o.seams,
          {.name = "seams",
           .affects = pages,
           .group = kTexture,
           .help =
               "Colour levelling across seams: none; global, one correction per chart and vertex; or full, that and a "
               "blend near the seam"}),
      Option(o.blend, {.name = "blend",
                       .affects = pages,
                       .group = kTexture,
                       .help = "coarse: what is coarser than some four pixels comes in part from all photos that see a "
                               "place whole, so that "
                               "they differ less along seams, while fine detail is that of one photo; none: every face "
                               "shows one photo alone"}),
      Option(o.max_pages, {.name = "max-pages",
                           .affects = pages,
                           .result = For::one_model,
                           .group = kTexture,
                           .kind = "N",
                           .least = 1,
                           .most = 1e6,
                           .help = "Reduce all charts by one factor to fit on N pages"}),
      Option(o.max_texels,
             {.name = "max-texels",
              .affects = pages,
              .result = For::one_model,
              .group = kTexture,
              .kind = "N",
              .least = 4096,
              .most = 1e15,
              .help = "Reduce all charts by one factor until all pages together have at most N texels, 4096 or more"}),
      Option(o.blend_cost, {.name = "blend-cost", .affects = pages}),
      Option(o.margin_px, {.name = "partial-margin", .affects = pages}));
}

template <io::Like<OutputSettings> T>
auto options_of(T& o) {
  using enum Affects;
  return std::tuple(
      Option(o.texture, {.name = "texture",
                         .affects = page_files,
                         .group = kTexture,
                         .help = "Format of the pages: jpg is quick to write and load, png is lossless"}),
      // Pages of two qualities may be those of one model.
      Option(o.quality, {.name = "quality",
                         .affects = models,
                         .group = kTexture,
                         .kind = "N",
                         .least = 1,
                         .most = 100,
                         .help = "JPEG quality of the pages, 1 to 100"}),
      Option(o.gltf, {.name = "gltf",
                      .affects = models,
                      .result = For::one_model,
                      .group = kTexture,
                      .help = "glb: one file, model.glb; files: model.gltf with model.bin and the pages beside it, "
                              "which is also written "
                              "for a model beyond the 4 GiB of a GLB"}),
      Option(o.normals, {.name = "normals",
                         .affects = models,
                         .result = For::one_model,
                         .group = kTexture,
                         .help = "Also write smooth normals, vn in the OBJ and NORMAL in the GLB; without them viewers "
                                 "do not shade the model"}),
      Option(o.up,
             {.name = "up",
              .affects = models,
              .group = kTexture,
              .help =
                  "Axis of the scene that points up in the GLB; auto: away from the cameras' mean viewing direction"}));
}

template <io::Like<Settings> T>
auto options_of(T& o) {
  using enum Affects;
  return std::tuple_cat(
      options_of(o.visibility), options_of(o.costs), options_of(o.solver), options_of(o.atlas), options_of(o.output),
      std::tuple(
          Option(o.device, {.name = "device", .affects = views}),
          Option(o.allow_unseen, {.name = "allow-unseen",
                                  .affects = nothing,
                                  .group = kChoosing,
                                  .help = "Texture a mesh of which all photos together see less than 5 % of the faces, "
                                          "which is refused otherwise: it "
                                          "is one in other coordinates as a rule"}),
          Option(o.view_rules, {.name = "allow", .affects = labels}),
          Option(o.edge_weights, {.name = "edge-weights",
                                  .affects = labels,
                                  .group = kChoosing,
                                  .help = "What a seam's cost is multiplied by: 1, the length of the edge, its "
                                          "flatness (seams are less visible in "
                                          "folds), or both"}),
          Option(o.memory_bytes, {.name = "memory",
                                  .affects = nothing,
                                  .group = kMachine,
                                  .kind = kBytes,
                                  .help = "Stay below this much memory, 600M or 4G; more of it saves decoding photos "
                                          "twice. The result is the same"}),
          Option(o.keep_work, {.name = "resume",
                               .affects = nothing,
                               .result = For::one_process,
                               .group = kMachine,
                               .help = "Keep finished work in OUT/.work until all is done, so that the same command "
                                       "goes on from there if it is cut "
                                       "off; auto: if it may take more than a minute"}),
          Option(o.editable,
                 {.name = "editable",
                  .affects = nothing,
                  .result = For::one_model,
                  .group = kChanging,
                  .help = "Also write edit-views.bin and edit-model.bin, with which the result can be changed"})));
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

/// Hashes the options on which a result depends, except view_rules.
inline void add_options(io::WorkHash& hash, const Settings& settings, Affects result) {
  for_each_option(settings, [&](const auto& value, const OptionInfo& info) {
    if constexpr (!std::same_as<std::remove_cvref_t<decltype(value)>, std::vector<ViewRule>>)
      if (info.affects <= result) hash.add(value);
  });
}

}  // namespace gpvc::pipeline
