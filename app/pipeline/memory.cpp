#include "app/pipeline/memory.h"

#include <fmt/format.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <limits>
#include <optional>
#include <sstream>

#include "app/pipeline/held_bytes.h"
#include "app/pipeline/settings.h"
#include "app/results/observer.h"
#include "atlas/atlas.h"
#include "labeling/labeling.h"

namespace gpvc::pipeline {
namespace {

namespace fs = std::filesystem;

// --- the machine

std::optional<double> number_in(const fs::path& file) {
  std::ifstream in(file);
  double number = 0;
  return in >> number ? std::optional(number) : std::nullopt;  // "max" is no number
}

// The value of a line "NAME: VALUE kB" or "NAME VALUE".
std::optional<double> field_of(const fs::path& file, const std::string& name) {
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    std::string word;
    double value = 0;
    if (words >> word >> value && (word == name || word == name + ":")) return value;
  }
  return std::nullopt;
}

// Bytes left below the limit of a group's folder. Files that the kernel keeps in memory count as used, but give way.
std::optional<double> left_in_group(const fs::path& folder, const char* limit, const char* used, const char* inactive) {
  const std::optional<double> most = number_in(folder / limit), now = number_in(folder / used);
  if (!most || !now) return std::nullopt;
  return std::max(0.0, *most - *now + field_of(folder / "memory.stat", inactive).value_or(0));
}

// The least that this process' group and those around it leave.
double left_in_groups(const fs::path& machine) {
  double least = std::numeric_limits<double>::infinity();
  std::ifstream in(machine / "proc/self/cgroup");
  for (std::string line; std::getline(in, line);) {
    // "0::PATH" in version 2, "N:CONTROLLERS:PATH" in version 1.
    const std::size_t first = line.find(':'), second = line.find(':', first + 1);
    if (second == std::string::npos) continue;
    const std::string controllers = line.substr(first + 1, second - first - 1);
    const bool v2 = controllers.empty();
    if (!v2 && controllers.find("memory") == std::string::npos) continue;
    const fs::path root = machine / (v2 ? "sys/fs/cgroup" : "sys/fs/cgroup/memory");
    for (fs::path group = fs::path(line.substr(second + 1)).relative_path();; group = group.parent_path()) {
      const auto left =
          v2 ? left_in_group(root / group, "memory.max", "memory.current", "inactive_file")
             : left_in_group(root / group, "memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file");
      if (left) least = std::min(least, *left);
      if (group.empty()) break;
    }
  }
  return least;
}

// --- the work

// Pixels of a face's projection; 0 unless it is seen from the front, all corners lie in front of the camera and one of them
// in the photo.
double framed_area(const View& view, const Mesh& mesh, const Triangle& face) {
  std::array<PixelPoint, 3> q;
  bool inside = false;
  for (std::size_t i = 0; i < 3; ++i) {
    const CameraPoint c = camera_from_world(view.pose, mesh.positions[face[i]]);
    if (!(c.z > 0)) return 0;
    q[i] = pixel_from_camera(view.camera, c);
    inside |= q[i].x >= 0 && q[i].y >= 0 && q[i].x <= view.camera.width && q[i].y <= view.camera.height;
  }
  // Corners run counterclockwise seen from the front, clockwise in pixels, whose y points down.
  const double twice = (q[1].y - q[0].y) * (q[2].x - q[0].x) - (q[1].x - q[0].x) * (q[2].y - q[0].y);
  const double frame = static_cast<double>(view.camera.width) * view.camera.height;
  return inside ? std::clamp(twice / 2, 0.0, frame) : 0;
}

constexpr double kMB = 1e6;

// Part of what baking needs: smaller batches of partial charts would decode photos again for the sake of little memory.
constexpr double kLeastBatch = 64 * kMB;
// Of the memory for pages and partial charts where not all fit: photos are decoded again for each group of pages and for
// each batch. Partial charts of a page take up to a quarter of what the page takes, and most pages have none.
constexpr double kPagesShare = 0.85;

// Threads that loops are shared out to: of the arena, fewer where a global_control allows fewer.
int usable_threads() {
  using Control = tbb::global_control;
  const auto allowed = static_cast<int>(Control::active_value(Control::max_allowed_parallelism));
  return std::min(allowed, tbb::this_task_arena::max_concurrency());
}

}  // namespace

std::size_t available_memory(const fs::path& root) {
  const std::optional<double> free_kb = field_of(root / "proc/meminfo", "MemAvailable");
  const double machine =
      free_kb ? 1024 * *free_kb
              : static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGE_SIZE));
  return static_cast<std::size_t>(std::min(machine, left_in_groups(root)));
}

std::size_t default_memory_limit() { return available_memory() / 10 * 7; }

double Workload::page_texel_bytes() const {
  return atlas::page_bytes_per_texel(static_cast<std::size_t>(sample_bytes)) + owner_bytes;
}

double Workload::photo_pixel_bytes() const { return held::kPhotoPixel + sample_bytes; }

Workload workload(const Input& input, const Settings& settings) {
  constexpr std::size_t kProjections = 2000000, kMostFaces = 20000;
  const std::size_t faces = input.mesh.faces.size();
  const std::size_t wanted =
      std::clamp<std::size_t>(kProjections / std::max<std::size_t>(1, input.views.size()), 1000, kMostFaces);
  const std::size_t step = std::max<std::size_t>(1, faces / wanted), count = (faces + step - 1) / step;
  std::vector<double> pairs(count, 0), pixels(count, 0), area(count, 0);
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t n) {
    for (const ViewId id : input.views) {
      const double px = framed_area(input.scene.views[index(id)], input.mesh, input.mesh.faces[n * step]);
      if (px > 0) pairs[n] += 1;
      pixels[n] += px;
      area[n] = std::max(area[n], px);
    }
  });
  Workload work;
  work.faces = static_cast<double>(faces);
  work.vertices = static_cast<double>(input.mesh.positions.size());
  work.views = static_cast<double>(input.views.size());
  if (input.scene.bands) work.sample_bytes = static_cast<double>(input.scene.bands->pixel_bytes());
  for (const ViewId id : input.views) {
    const Camera& camera = input.scene.views[index(id)].camera;
    const double px = static_cast<double>(camera.width) * camera.height;
    work.pixels += px;
    work.most_pixels = std::max(work.most_pixels, px);
  }
  for (std::size_t n = 0; n < count; ++n) {
    work.pairs += pairs[n] * static_cast<double>(step);
    work.pair_pixels += pixels[n] * static_cast<double>(step);
    work.texels += area[n] * static_cast<double>(step);
  }
  const atlas::AtlasOptions& atlas = settings.atlas;
  if (input.layout != nullptr) {
    work.texels = 0;
    work.owner_bytes = atlas::kOwnerBytesPerTexel;
    for (const io::UvPage& page : input.layout->pages) {
      const double texels = static_cast<double>(page.width) * page.height;
      work.texels += texels;
      work.page_texels = std::max(work.page_texels, texels);
    }
    return work;
  }
  // Pages are about four fifths full.
  work.texels /= 0.8;
  work.page_texels = static_cast<double>(atlas.page_size) * atlas.page_size;
  if (atlas.max_texels > 0) work.texels = std::min(work.texels, static_cast<double>(atlas.max_texels));
  if (atlas.max_pages > 0)
    work.texels = std::min(work.texels, static_cast<double>(atlas.max_pages) * atlas.page_size * atlas.page_size);
  return work;
}

MemoryNeed memory_need(const Workload& work, int threads) {
  using namespace held;
  const double always = run_of(work);
  // Each thread that averages a view, or cuts the graph of a label, has an index of all faces. Those of two threads are in
  // the factors, which were fitted on two.
  const double of_threads = kIndex * work.faces * std::max(0.0, std::min<double>(threads, work.views) - 2);
  MemoryNeed need;
  // Records and the candidates that are made from them; classes of two views and two indices a face.
  need.see = always + of_threads + (kRecord + kCandidate) * work.pairs + view(work) + previews(work) +
             2 * (sizeof(visibility::FaceClass) + kIndex) * work.faces;
  // Where faces are large this is the most: views see less of them than frames hold, and differ in few. It took 0.23 to 0.38 of the
  // bound on seven scenes. Where they are small it took up to 0.63, and looking takes more.
  constexpr double kJudged = 0.4;
  need.judge = while_judging(work) + of_threads + kRecord * work.pairs +
               kJudged * labeling::judging_bytes(work.pairs, work.pair_pixels, work.faces);
  // The candidates twice, and as much again in the chain of coarser problems; their labels, costs and neighbours.
  need.choose = always + of_threads + 2 * 2 * kCandidate * work.pairs + 2.5 * kNeighbours * work.faces;
  // Photos. Views at vertices, of which there are half as many as faces, where they are blended: 16 bytes each. Charts, texture
  // coordinates and offsets of the faces.
  constexpr double kCharts = 250, kVertexView = 16;
  need.bake =
      always + (kCandidate + kVertexView / 2) * work.pairs +
      (work.photo_pixel_bytes() * static_cast<double>(atlas::photos_held()) + decoding_pixel(work)) * work.most_pixels +
      kCharts * work.faces;
  // Texture coordinates and the pieces of the GLB; the preview and the pages that it is drawn with.
  constexpr double kWrittenFace = 40, kPreview = 120e6;
  need.write = kProgram + mesh(work) + kWrittenFace * work.faces + kPreview;
  return need;
}

double predicted_seconds(const Workload& work, int threads) {
  // Fitted to the same runs: processor seconds for start and preview, for a million pairs, texels and faces. Stages with
  // little to do side by side leave cores idle for a seventh of the time.
  const double cpu_s = 1.4 + 1e-6 * (0.6 * work.pairs + 0.48 * work.texels + 7.6 * work.faces);
  return 0.4 + cpu_s / (threads > 1 ? 0.86 * threads : 1);
}

std::size_t MemoryPlan::photos_while_seeing() const {
  return static_cast<std::size_t>(std::max(0.0, limit - need.see));
}

std::size_t MemoryPlan::photos_while_judging(double held) const {
  return static_cast<std::size_t>(std::max(0.0, limit - held::while_judging(work) - held));
}

std::size_t MemoryPlan::photos_while_choosing() const {
  return static_cast<std::size_t>(std::max(0.0, limit - std::max(need.see, need.choose)));
}

MemoryPlan::Shares MemoryPlan::while_baking(double all_pages, double page) const {
  const double room = std::max(0.0, limit - need.bake);
  const auto bytes = [](double size) { return static_cast<std::size_t>(size); };
  const auto batch = [&](double pages) { return std::max(kLeastBatch, atlas::kFinishedPart * pages); };
  if (all_pages <= room) {
    const double half = (room - all_pages) / 2;
    return {bytes(all_pages), bytes(batch(all_pages) + half), bytes(half)};
  }
  const double some_pages = std::max(page, kPagesShare * room);
  return {bytes(some_pages), bytes(batch(some_pages) + std::max(0.0, room - some_pages)), 0};
}

double MemoryPlan::peak() const {
  const double pages = work.page_texel_bytes() * work.texels, photos = work.photo_pixel_bytes() * work.pixels;
  // Needs are upper bounds, which a promise is made with: of these and of the limit, runs on ten scenes of different shape
  // took 0.76 to 1.04.
  constexpr double kTypical = 0.87;
  return kTypical * std::min(limit, std::max({need.see + photos, need.judge, need.choose + photos,
                                              need.bake + pages + photos, need.write}));
}

namespace {

// For the web, pages are decoded and encoded anew, one on each thread: three bytes of a texel decoded, half as many as WebP has
// them, and one of the encoder's.
double web_pages_bytes(const Workload& work, const Settings& settings, int threads) {
  constexpr double kTexel = 5.5;
  if (settings.output.target == Target::full) return 0;
  const double page = static_cast<double>(settings.atlas.page_size) * settings.atlas.page_size;
  return kTexel * std::min(work.texels, page * threads);
}

// Entries are also sorted by face.
double held_by(const visibility::CoverageTable& coverage) {
  return static_cast<double>(coverage.entries.size() * (sizeof(visibility::FaceCoverage) + sizeof(std::uint32_t)) +
                             coverage.words.size() * sizeof(std::uint64_t));
}

MemoryPlan plan_for(const Workload& work, const MemoryNeed& need, const Settings& settings,
                    double promised = std::numeric_limits<double>::infinity()) {
  MemoryPlan plan;
  plan.need = need;
  plan.work = work;
  // At least one page is baked at a time.
  const double texel = work.page_texel_bytes();
  const double all_pages = texel * work.texels;
  const double page = std::min(texel * work.page_texels, all_pages);
  const double least =
      std::max({plan.need.see, plan.need.judge, plan.need.choose, plan.need.write, plan.need.bake + page});
  const auto most = static_cast<double>(settings.memory_bytes > 0 ? settings.memory_bytes : default_memory_limit());
  if (least > most && most < promised)
    throw MemoryError(fmt::format("this run needs about {} of memory, and {} may be used ({})",
                                  results::readable_bytes(least), results::readable_bytes(most),
                                  settings.memory_bytes > 0 ? "the limit that is set" : "70 % of what is available"),
                      {Cure::more_memory, Cure::smaller_photos, Cure::fewer_views, Cure::fewer_faces},
                      {{"needed_bytes", least}, {"allowed_bytes", most}});
  // Some memory is lost between blocks that are in use: a promise needs a reserve.
  constexpr double kKeep = 0.93;
  // Pages that are baked together save decoding photos again for each of them.
  constexpr double kModestPages = 500 * kMB, kModestPhotos = 100 * kMB;
  // They may turn out larger than predicted: large charts leave more of a page empty.
  constexpr double kReserve = 1.3;
  const double pages = std::min(kReserve * all_pages, std::max(page, kModestPages) / kPagesShare);
  // So do photos, if all are kept, for which baking leaves half of what its pages do not take.
  const double all_photos = work.photo_pixel_bytes() * work.pixels,
               photos = all_photos <= kModestPhotos ? all_photos : 0;
  const double lean = std::max({plan.need.see + photos, plan.need.judge, plan.need.choose + photos, plan.need.write,
                                plan.need.bake + pages + 2 * photos});
  plan.limit = std::max(least, settings.memory_bytes > 0 ? kKeep * most : std::min(most, lean));
  plan.most = settings.memory_bytes > 0 ? plan.limit : std::max(plan.limit, most);
  return plan;
}

}  // namespace

MemoryPlan plan_memory(const Input& input, const Settings& settings) {
  const Workload work = workload(input, settings);
  MemoryNeed need = memory_need(work, usable_threads());
  need.write += web_pages_bytes(work, settings, usable_threads());
  return plan_for(work, need, settings);
}

MemoryPlan plan_baking(const Input& input, const Settings& settings, const visibility::CoverageTable& coverage,
                       double promised) {
  const Workload work = workload(input, settings);
  return plan_for(work, {.bake = memory_need(work).bake + held_by(coverage)}, settings, promised);
}

MemoryPlan with_coverage(MemoryPlan plan, const visibility::CoverageTable& coverage) {
  const double held = held_by(coverage);
  plan.need.bake += held;
  plan.limit = std::min(plan.most, plan.limit + held);
  return plan;
}

void throw_out_of_memory(double needed) {
  throw MemoryError(
      fmt::format("out of memory: this run takes about {}, and less was to be had", results::readable_bytes(needed)),
      {Cure::limit_memory, Cure::smaller_photos, Cure::fewer_views, Cure::fewer_faces}, {{"needed_bytes", needed}});
}

}  // namespace gpvc::pipeline
