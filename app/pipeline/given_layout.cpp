#include "app/pipeline/given_layout.h"

#include <fmt/format.h>

#include <algorithm>

#include "app/pipeline/texture_files.h"
#include "atlas/atlas.h"
#include "io/images.h"
#include "labeling/labeling.h"

namespace gpvc::pipeline {
namespace {

using results::readable_count;

void refuse_settings(const Settings& settings, const io::UvLayout& layout, const std::filesystem::path& mesh) {
  const auto refuse = [&](bool wanted, const char* what) {
    if (wanted)
      throw InputError(mesh, "", fmt::format("is textured on its own texture coordinates, which excludes {}", what));
  };
  const atlas::AtlasOptions& atlas = settings.atlas;
  refuse(atlas.max_pages > 0 || atlas.max_texels > 0 || atlas.texel_size > 0,
         "limits of pages, texels and texel sizes: pages have the sizes that are asked for");
  if (settings.output.target != Target::web) return;
  for (const io::UvPage& page : layout.pages)
    if (std::max(page.width, page.height) > io::kMostWebpEdge)
      throw InputError(
          mesh, "",
          fmt::format("has a page of {} x {} texels, and a WebP of a model for the web has at most {} an edge; "
                      "expected a smaller page size",
                      page.width, page.height, io::kMostWebpEdge));
}

std::string sizes_text(const io::UvLayout& layout) {
  const auto size = [](const io::UvPage& page) { return static_cast<double>(page.width) * page.height; };
  const auto [least, most] = std::ranges::minmax_element(layout.pages, {}, size);
  std::string text = fmt::format("{} {} of {} x {}", layout.pages.size(), layout.pages.size() == 1 ? "page" : "pages",
                                 least->width, least->height);
  if (least->width != most->width || least->height != most->height)
    text += fmt::format(" to {} x {}", most->width, most->height);
  return text;
}

void note(const io::UvLayout& layout, const atlas::UvFigures& found, Observer& observer) {
  observer.figure("layout.islands", found.islands);
  observer.figure("layout.mirrored_islands", found.mirrored_islands);
  observer.figure("layout.faces_without", found.faces_without);
  observer.figure("layout.flat_faces", found.flat_faces);
  observer.figure("layout.overlapping_texels", found.overlapping_texels);
  observer.figure("layout.overlapping_faces", found.overlapping_faces);
  observer.figure("layout.repeated_faces", layout.repeated_faces);
  std::string text = fmt::format("layout: {} islands on {}", readable_count(found.islands), sizes_text(layout));
  if (layout.has_udim_tiles) text += ", UDIM tiles";
  if (found.mirrored_islands > 0)
    text += fmt::format("; {} islands are mirrored", readable_count(found.mirrored_islands));
  observer.note(text);
  if (found.faces_without > 0)
    observer.warning(
        fmt::format("{} faces have no texture coordinates: they stay without texture, grey in the OBJ and "
                    "left out of the GLB",
                    readable_count(found.faces_without)));
  if (found.flat_faces > 0)
    observer.warning(
        fmt::format("{} faces have texture coordinates in a line or a point, and get no texels of their own",
                    readable_count(found.flat_faces)));
  if (layout.repeated_faces > 0)
    observer.warning(
        fmt::format("{} faces lie beyond 0 .. 1, and some of them below 0 or above u = 10, so they are no UDIM tiles: "
                    "they are baked "
                    "where a texture that repeats has them",
                    readable_count(layout.repeated_faces)));
  if (found.overlapping_texels > 0)
    observer.warning(
        fmt::format("{} texels lie under several of {} faces whose texture coordinates overlap: each is baked once, "
                    "for one of them, and the "
                    "others show the same",
                    readable_count(found.overlapping_texels), readable_count(found.overlapping_faces)));
}

}  // namespace

void look_at_layout(const Run& run) {
  const Input& input = run.input;
  if (input.layout == nullptr) return;
  atlas::check_layout(input.mesh, *input.layout);
  refuse_settings(run.settings, *input.layout, input.mesh_file);
  const atlas::UvFigures found = atlas::measure_uv(input.mesh, labeling::face_graph(input.mesh), *input.layout);
  if (found.islands == 0)
    throw InputError(
        input.mesh_file, "",
        "has no texture coordinates, expected some to texture it on; a program that unwraps meshes makes them");
  if (found.overlapping_texels > 0 && run.settings.overlap == Overlap::refuse)
    throw InputError(input.mesh_file, "texture coordinates",
                     fmt::format("overlap: {} texels lie under several of {} faces, expected one face a texel",
                                 found.overlapping_texels, found.overlapping_faces));
  note(*input.layout, found, run.observer);
}

std::string page_suffix(const Input& input, std::size_t number) {
  return input.layout == nullptr ? fmt::format("_{}", number) : input.layout->pages[number].suffix;
}

std::string page_file_name(const Input& input, std::size_t number, io::ImageFormat format) {
  return fmt::format("model{}.{}", page_suffix(input, number), name_of(io::kImageFormatNames, format));
}

}  // namespace gpvc::pipeline
