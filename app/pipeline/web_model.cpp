#include "app/pipeline/web_model.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <string>
#include <system_error>
#include <utility>

#include "io/images.h"

namespace gpvc::pipeline {
namespace {

namespace fs = std::filesystem;

constexpr int kLeastQuality = 50, kFallbackQuality = 75, kFallbackReduction = 4;

struct Density {
  int quality;
  double bytes;  ///< a texel
};
// What WebP takes for a page of a park, by its quality.
constexpr Density kDensities[] = {{0, 0.03},   {20, 0.049}, {30, 0.067}, {40, 0.079}, {50, 0.092},
                                  {60, 0.102}, {70, 0.118}, {75, 0.125}, {80, 0.159}, {85, 0.191},
                                  {90, 0.247}, {95, 0.337}, {98, 0.432}, {100, 0.6}};

double density(int quality) {
  const auto* above = std::ranges::lower_bound(kDensities, std::max(quality, 1), {}, &Density::quality);
  const auto* below = above - 1;
  const double share = static_cast<double>(quality - below->quality) / (above->quality - below->quality);
  return below->bytes + share * (above->bytes - below->bytes);
}

// The highest quality below one that is expected to make `ratio` of its bytes.
int lower_quality(int quality, double ratio) {
  constexpr double kReserve = 0.97;
  const double wanted = kReserve * ratio * density(quality);
  do {
    --quality;
  } while (quality > 0 && density(quality) > wanted);
  return quality;
}

std::size_t size_of(const fs::path& file) {
  std::error_code failed;
  const std::uintmax_t bytes = fs::file_size(file, failed);
  if (failed) throw InputError(file, "", "cannot be read: " + failed.message());
  return bytes;
}

// Texture coordinates mean the same places of a page as long as no column is cut off.
bool divides(int factor, const Image& page) { return page.width % factor == 0 && page.height % factor == 0; }

struct Coding {
  const OutputSettings& settings;
  io::GltfContainer container;
  int quality = 0, reduction = 1;
};

struct WebPage {
  io::PageFile made;
  std::size_t bytes = 0;
  bool can_shrink = false;
};

WebPage write_page(const io::PageFile& source, const std::string& stem, const Coding& coding) {
  constexpr int kLeastEdge = 64;
  WebPage page;
  const Image image = io::reduce_image(io::read_image(source.file), coding.reduction);
  page.can_shrink = divides(2, image) && std::min(image.width, image.height) >= 2 * kLeastEdge;
  page.made = {stem + ".webp", io::ImageFormat::webp};
  io::write_image(page.made.file, image, io::ImageFormat::webp, coding.quality);
  page.bytes = size_of(page.made.file);
  if (!coding.settings.jpeg_fallback) return page;
  if (coding.container == io::GltfContainer::files) {
    page.made.fallback = source.file;
    page.made.fallback_format = source.format;
    return page;
  }
  int factor = kFallbackReduction;
  while (!divides(factor, image)) factor /= 2;
  page.made.fallback = stem + "_small.jpg";
  io::write_image(page.made.fallback, io::reduce_image(image, factor), io::ImageFormat::jpg, kFallbackQuality);
  page.bytes += size_of(page.made.fallback);
  return page;
}

WebPages write_pages(std::span<const io::PageFile> sources, const fs::path& stem, const Coding& coding) {
  std::vector<WebPage> pages(sources.size());
  tbb::parallel_for(std::size_t{0}, pages.size(), [&](std::size_t n) {
    pages[n] = write_page(sources[n], fmt::format("{}_{}", stem.string(), n), coding);
  });
  WebPages all{{}, {}, 0, coding.quality, coding.reduction, true};
  for (std::size_t n = 0; n < pages.size(); ++n) {
    WebPage& page = pages[n];
    all.written.push_back(page.made.file);
    if (!page.made.fallback.empty() && page.made.fallback != sources[n].file) all.written.push_back(page.made.fallback);
    all.files.push_back(std::move(page.made));
    all.bytes += page.bytes;
    all.can_shrink &= page.can_shrink;
  }
  return all;
}

// The pages written anew until they take `most` bytes, or cannot be made smaller.
WebPages shrunk(WebPages made, std::span<const io::PageFile> sources, const fs::path& stem, const Run& run,
                std::size_t most) {
  const OutputSettings& settings = run.settings.output;
  const int least = std::min(kLeastQuality, settings.webp_quality);
  while (made.bytes > most) {
    run.observer.check_cancelled();
    int quality = lower_quality(made.quality, static_cast<double>(most) / static_cast<double>(made.bytes));
    int reduction = made.reduction;
    if (quality < least) {
      if (!made.can_shrink) break;
      quality = settings.webp_quality;
      reduction *= 2;
    }
    made = write_pages(sources, stem, {settings, settings.gltf, quality, reduction});
  }
  return made;
}

// Models may be small, and what is missing less than a megabyte.
std::string megabytes(std::size_t bytes) { return fmt::format("{:.3g} MB", static_cast<double>(bytes) / 1e6); }

std::size_t most_bytes(const OutputSettings& settings) {
  return settings.max_bytes > 0 ? settings.max_bytes : kWebBytes;
}

// A corner's floats, for each corner of a face, and its indices: more than any coding takes of a face.
constexpr std::size_t kMostOfFace = 3 * 40;
// The JSON of a glTF, and what each page adds to it.
constexpr std::size_t kDescription = 4096, kPageDescription = 1024;

// Pages that fit into the model's bytes beside its geometry.
WebPages fitting_pages(const Run& run, const io::TexturedModel& model, std::span<const io::PageFile> sources,
                       const fs::path& stem, const io::ModelOptions& options) {
  WebPages made = write_web_pages(sources, stem, run.settings.output, run.settings.output.gltf);
  const std::size_t most = most_bytes(run.settings.output);
  const std::size_t description = kDescription + kPageDescription * sources.size();
  if (made.bytes + description + kMostOfFace * model.face_page.size() <= most) return made;
  const std::size_t geometry = description + io::gltf_geometry_bytes(model, sources.size(), options);
  made = shrunk(std::move(made), sources, stem, run, most > geometry ? most - geometry : 0);
  if (geometry + made.bytes > most)
    throw OutputError(
        stem.string() + ".glb",
        fmt::format("would have {} with the smallest pages, {} of them for its geometry, and {} are allowed",
                    megabytes(geometry + made.bytes), megabytes(geometry), megabytes(most)),
        {Cure::more_bytes, Cure::fewer_faces});
  return made;
}

}  // namespace

Settings with_target(Settings settings, std::size_t faces, bool has_layout) {
  OutputSettings& output = settings.output;
  if (output.target == Target::full) return settings;
  output.max_bytes = most_bytes(output);
  atlas::AtlasOptions& atlas = settings.atlas;
  if (atlas.max_pages == 0 && !has_layout) atlas.max_pages = 1;
  // Quantized geometry of a park takes 4.5 bytes of a face, that of a city of many charts 9; indices never take less than
  // one. A fallback adds 8 % to a page.
  constexpr std::size_t kLeastOfFace = 1;
  constexpr double kFace = 6, kWithFallback = 1.1, kLeastTexels = 4096;
  const auto count = static_cast<double>(faces), most = static_cast<double>(output.max_bytes);
  if (kLeastOfFace * faces > output.max_bytes)
    throw InputError(fmt::format("{} faces take {} or more, and the model may have {}", results::readable_count(faces),
                                 megabytes(kLeastOfFace * faces), megabytes(output.max_bytes)),
                     {Cure::more_bytes, Cure::fewer_faces});
  if (has_layout) return settings;
  const double texels = std::max(most - kFace * count, most / 4) / (kWithFallback * density(output.webp_quality));
  const double pages = static_cast<double>(atlas.max_pages) * atlas.page_size * atlas.page_size;
  if (texels < pages && (atlas.max_texels == 0 || texels < static_cast<double>(atlas.max_texels)))
    atlas.max_texels = static_cast<std::size_t>(std::max(texels, kLeastTexels));
  return settings;
}

WebPages write_web_pages(std::span<const io::PageFile> pages, const fs::path& stem, const OutputSettings& settings,
                         io::GltfContainer container) {
  return write_pages(pages, stem, {settings, container, settings.webp_quality, 1});
}

void WebPages::remove() const noexcept {
  std::error_code ignored;
  for (const fs::path& file : written) fs::remove(file, ignored);
}

WebModel write_web_model(const Run& run, const fs::path& stem, const io::TexturedModel& model,
                         std::span<const io::PageFile> pages, io::ModelOptions options) {
  options.normals = options.normals || options.lit;
  WebModel made;
  made.pages = fitting_pages(run, model, pages, stem, options);
  made.files = io::write_gltf(stem, run.settings.output.gltf, model, made.pages.files, options);
  made.bytes = size_of(made.files.file);
  if (made.files.buffers.empty())
    made.pages.remove();
  else
    made.bytes += made.pages.bytes;
  for (const fs::path& buffer : made.files.buffers) made.bytes += size_of(buffer);
  return made;
}

void report(const WebModel& model, Observer& observer) {
  const WebPages& pages = model.pages;
  observer.figure("web.bytes", model.bytes);
  observer.figure("web.page_bytes", pages.bytes);
  observer.figure("web.quality", static_cast<std::size_t>(pages.quality));
  observer.figure("web.reduction", static_cast<std::size_t>(pages.reduction));
  observer.note(fmt::format("for the web: {}, {} of them pages, WebP of quality {}{}", megabytes(model.bytes),
                            megabytes(pages.bytes), pages.quality,
                            pages.reduction > 1 ? fmt::format(", 1/{} of their edges", pages.reduction) : ""));
}

}  // namespace gpvc::pipeline
