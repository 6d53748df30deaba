// retexture_into: an earlier result with other rules about views.
#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <future>
#include <new>
#include <set>
#include <utility>

#include "app/pipeline/bake_into.h"
#include "app/pipeline/edit_files.h"
#include "app/pipeline/given_layout.h"
#include "app/pipeline/steps.h"
#include "app/pipeline/texture_files.h"
#include "io/clock.h"
#include "io/freed_memory.h"
#include "io/images.h"

namespace gpvc::pipeline {
namespace {

namespace fs = std::filesystem;

constexpr std::uint32_t kDropped = 0xFFFFFFFFu;

/// What is known before labels are chosen.
struct Earlier {
  EditModel model;
  labeling::FaceGraph graph;
  labeling::Candidates candidates;  ///< with the new rules
  CoverageStore coverage;
  std::vector<FaceId> changed;  ///< faces whose candidates differ from those with the earlier rules
};

std::vector<FaceId> differing_faces(const labeling::Candidates& a, const labeling::Candidates& b) {
  std::vector<FaceId> faces;
  for (std::uint32_t f = 0; f < a.tags.size(); ++f)
    if (a.tags[f] != b.tags[f] || !std::ranges::equal(a.table.views_of(f), b.table.views_of(f)) ||
        !std::ranges::equal(a.table.costs_of(f), b.table.costs_of(f)))
      faces.push_back(FaceId{f});
  return faces;
}

Earlier read_earlier(const fs::path& from, const Run& run) {
  const auto& [input, settings, photos, observer, kept] = run;
  observer.begin({"earlier result"});
  Earlier earlier{read_edit_model(from), {}, {}, {}, {}};
  const ResultKeys& keys = earlier.model.keys;
  if (const std::string differs = difference(keys, result_keys(run)); !differs.empty())
    throw InputError(from, "", differs + "; only the rules about photos and the form of the models may differ");
  check_edit_model(from, input, earlier.model, input.layout != nullptr);
  labeling::CandidateCollector collector(input.mesh, settings.costs);
  read_edit_views(from, input, keys, collector, earlier.coverage);
  Observer silent;  // what the earlier rules say has been reported
  const std::size_t views = input.scene.views.size();
  const labeling::Candidates before =
      collector.candidates(allowed_views(earlier.model.rules, input.mesh, views, silent));
  const auto allowed = allowed_views(settings.view_rules, input.mesh, views, observer);
  earlier.candidates = collector.finish(nullptr, allowed);
  earlier.changed = differing_faces(before, earlier.candidates);
  observer.end(fmt::format("{} of {} faces have other candidates", results::readable_count(earlier.changed.size()),
                           results::readable_count(input.mesh.faces.size())));
  report_tags(input, earlier.candidates, observer);
  if (allowed) report_refused(earlier.candidates.refused, observer);
  return earlier;
}

/// Which faces get new texels, and what becomes of the earlier pages.
struct Change {
  std::vector<std::uint8_t> kept;  ///< per face: 1 if it keeps its texels, which makes it a border of the others
  std::vector<std::uint32_t> page_number;  ///< per earlier page; kDropped where no face is left on it
  std::size_t pages_kept = 0, faces = 0, charts_touched = 0, charts_kept = 0;
};

Change find_change(const EditModel& before, std::span<const FaceId> changed, std::span<const ViewId> labels) {
  Change change;
  change.kept.assign(labels.size(), 1);
  for (const FaceId face : changed) change.kept[index(face)] = 0;
  for (std::size_t f = 0; f < labels.size(); ++f)
    if (labels[f] != before.labels[f]) change.kept[f] = 0;
  change.faces = static_cast<std::size_t>(std::ranges::count(change.kept, 0));
  std::vector<std::uint8_t> used(before.page_sizes.size(), 0);
  std::set<std::uint32_t> charts(before.face_chart.begin(), before.face_chart.end()), touched;
  for (std::size_t f = 0; f < labels.size(); ++f) {
    if (change.kept[f] == 0)
      touched.insert(before.face_chart[f]);
    else if (before.model.face_page[f] != io::kNoPage)
      used[before.model.face_page[f]] = 1;
  }
  change.charts_touched = touched.size();
  change.charts_kept = charts.size() - touched.size();
  for (const std::uint8_t page : used)
    change.page_number.push_back(page != 0 ? static_cast<std::uint32_t>(change.pages_kept++) : kDropped);
  return change;
}

/// Where places are given, new texels would lie beside earlier ones on the same page: if any face changes, all are made.
Change on_given_places(Change change) {
  if (change.faces == 0) return change;
  std::ranges::fill(change.kept, std::uint8_t{0});
  std::ranges::fill(change.page_number, kDropped);
  change.faces = change.kept.size();
  change.pages_kept = 0;
  change.charts_touched += std::exchange(change.charts_kept, 0);
  return change;
}

/// Flags of the earlier pages that kept faces beside others use: a vertex in common counts, since holes are filled from there.
std::vector<std::uint8_t> pages_beside(const Mesh& mesh, const EditModel& before, const Change& change) {
  std::vector<std::uint8_t> vertex(mesh.positions.size(), 0), pages(before.page_sizes.size(), 0);
  for (std::size_t f = 0; f < mesh.faces.size(); ++f)
    if (change.kept[f] == 0)
      for (const std::uint32_t v : mesh.faces[f]) vertex[v] = 1;
  for (std::size_t f = 0; f < mesh.faces.size(); ++f)
    if (change.kept[f] != 0 && std::ranges::any_of(mesh.faces[f], [&](std::uint32_t v) { return vertex[v] != 0; }))
      pages[before.model.face_page[f]] = 1;
  return pages;
}

/// Earlier pages by number, and their samples where photos have bands; empty where new charts do not need their colours.
struct PagesBeside {
  std::vector<Image> images;
  std::vector<Samples> samples;
};

/// The samples of an earlier page. Throws InputError where they are not those of this page.
Samples earlier_samples(const fs::path& file, const BandSet& bands, const Image& page) {
  Samples samples = io::read_samples(file);
  if (samples.width != page.width || samples.height != page.height || samples.bands != bands.bands.size() ||
      samples.type != bands.type)
    throw InputError(file, "", "is not what was written there with its page", {Cure::make_editable});
  return samples;
}

/// Copies the pages that are kept, and returns those whose colours the new charts need.
PagesBeside keep_pages(const fs::path& from, const Input& input, const EditModel& before, const Change& change,
                       const Settings& settings, ModelFiles& files) {
  const std::vector<std::uint8_t> needed = pages_beside(input.mesh, before, change);
  PagesBeside pages{std::vector<Image>(needed.size()), std::vector<Samples>(needed.size())};
  tbb::parallel_for(std::size_t{0}, needed.size(), [&](std::size_t p) {
    if (change.page_number[p] == kDropped) return;
    const fs::path file = from / page_file_name(input, p, settings.output.texture);
    if (page_file_key(file) != before.page_files[p])
      throw InputError(file, "", "is not the page that was written there", {Cure::make_editable});
    Image page = io::read_image(file);
    if (page.width != before.page_sizes[p][0] || page.height != before.page_sizes[p][1])
      throw InputError(file, "",
                       fmt::format("expected the page of {} x {} texels that was written there, found {} x {}",
                                   before.page_sizes[p][0], before.page_sizes[p][1], page.width, page.height));
    if (input.scene.bands) {
      const fs::path samples = samples_of(file, settings.output.band_format);
      if (needed[p] != 0) pages.samples[p] = earlier_samples(samples, *input.scene.bands, page);
      files.keep_samples(change.page_number[p], samples);
    }
    files.keep_page(change.page_number[p], file, page);
    if (needed[p] != 0) pages.images[p] = std::move(page);
  });
  return pages;
}

/// Replaces the texture coordinates of faces that are not kept by those that `made` gives them.
io::TexturedModel joined(const EditModel& before, const Change& change, const io::TexturedModel& made) {
  const io::TexturedModel& old = before.model;
  std::vector<std::uint32_t> number(old.texcoords.size(), 0);
  for (std::size_t f = 0; f < change.kept.size(); ++f)
    if (change.kept[f] != 0)
      for (const std::uint32_t t : old.face_texcoords[f]) number[t] = 1;
  io::TexturedModel model;
  model.mesh = made.mesh;
  if (change.pages_kept == 0) model.obj_texcoords = made.obj_texcoords;
  for (std::size_t t = 0; t < number.size(); ++t) {
    if (number[t] == 0) continue;
    number[t] = static_cast<std::uint32_t>(model.texcoords.size());
    model.texcoords.push_back(old.texcoords[t]);
  }
  const auto first_made = static_cast<std::uint32_t>(model.texcoords.size());
  model.texcoords.insert(model.texcoords.end(), made.texcoords.begin(), made.texcoords.end());
  model.face_texcoords.resize(change.kept.size());
  model.face_page.resize(change.kept.size());
  for (std::size_t f = 0; f < change.kept.size(); ++f) {
    const bool kept = change.kept[f] != 0;
    for (std::size_t i = 0; i < 3; ++i)
      model.face_texcoords[f][i] = kept ? number[old.face_texcoords[f][i]] : first_made + made.face_texcoords[f][i];
    model.face_page[f] =
        kept ? change.page_number[old.face_page[f]] : static_cast<std::uint32_t>(change.pages_kept) + made.face_page[f];
  }
  return model;
}

/// The result of a run: models, and what the next one needs.
EditModel joined_edit_model(const EditModel& before, const Settings& settings, const Change& change,
                            std::vector<ViewId> labels, const io::TexturedModel& model, const atlas::TextureAtlas& made,
                            std::vector<std::array<int, 2>> page_sizes) {
  EditModel after{
      before.keys,     settings.view_rules, std::move(labels), model, std::move(page_sizes), before.face_chart,
      before.exposure, before.alignment,    before.reduction,  {}};
  const std::uint32_t first = 1 + *std::ranges::max_element(before.face_chart);
  for (std::size_t f = 0; f < change.kept.size(); ++f)
    if (change.kept[f] == 0) after.face_chart[f] = first + made.face_chart[f];
  return after;
}

void report_change(const Change& change, std::size_t free_faces, const atlas::AtlasStatistics& made, double seconds,
                   Observer& observer) {
  observer.figure("charts", change.charts_kept + change.charts_touched + made.charts);
  observer.figure("pages", change.pages_kept + made.pages);
  observer.figure("edit.faces_solved", free_faces);
  observer.figure("edit.faces_made", change.faces);
  observer.figure("edit.charts_kept", change.charts_kept);
  observer.figure("edit.charts_touched", change.charts_touched);
  observer.figure("edit.charts_made", made.charts);
  observer.figure("edit.pages_kept", change.pages_kept);
  observer.figure("edit.pages_made", made.pages);
  observer.figure("edit.seconds", seconds);
  if (change.faces == 0) return observer.note("nothing changes: the result is a copy of the earlier one");
  observer.note(fmt::format(
      "{} faces solved again, {} of them with new texels: {} charts touched, {} made, {} as they were; {} {} kept byte "
      "for byte, {} made",
      results::readable_count(free_faces), results::readable_count(change.faces),
      results::readable_count(change.charts_touched), results::readable_count(made.charts),
      results::readable_count(change.charts_kept), change.pages_kept, change.pages_kept == 1 ? "page" : "pages",
      made.pages));
}

/// The atlas of the faces that are not kept, on pages that follow the kept ones.
class Remaking final : public PageSink {
 public:
  Remaking(const fs::path& from, const Run& run, const Earlier& earlier, const Change& change, ModelFiles& files)
      : from_(from),
        run_(run),
        earlier_(earlier),
        change_(change),
        files_(files),
        beside_{std::vector<Image>(earlier.model.page_sizes.size()),
                std::vector<Samples>(earlier.model.page_sizes.size())} {}

  atlas::TextureAtlas make(std::span<const ViewId> labels, OutputFolder& folder) {
    if (change_.faces == 0) return copied();
    const visibility::CoverageTable coverage = coverage_of_made();
    std::vector<atlas::ViewExposure> exposure = earlier_.model.exposure;
    exposure.resize(run_.input.scene.views.size());  // without seams there was nothing to fit them to
    const std::vector<ShiftField> alignment = alignment_of_views();
    const atlas::FinishedTexture finished{earlier_.model.model, beside_.images, earlier_.model.reduction,
                                          beside_.samples};
    const MemoryPlan memory = with_coverage(plan_memory(run_.input, run_.settings), coverage);
    const FileSizes sizes = predicted_sizes(run_.input, run_.settings, memory.work.texels);
    io::CoarsePhotos photos = with_coarse_photos(run_, memory.work, sizes.likely, folder.in_making());
    const atlas::AtlasInput from{run_.input.mesh,
                                 run_.input.scene,
                                 photos,
                                 earlier_.graph,
                                 labels,
                                 earlier_.candidates.tags,
                                 earlier_.candidates.table,
                                 coverage,
                                 change_.kept,
                                 exposure,
                                 run_.input.layout == nullptr ? &finished : nullptr,
                                 {},
                                 alignment,
                                 run_.input.layout};
    return bake_into(run_, from, memory, {.scratch_folder = folder.in_making()}, this);
  }

  void begin(const atlas::AtlasEstimate& size) override {
    atlas::AtlasEstimate all = size;
    all.pages += change_.pages_kept;
    for (std::size_t p = 0; p < change_.page_number.size(); ++p)
      if (change_.page_number[p] != kDropped)
        all.page_texels += static_cast<std::size_t>(earlier_.model.page_sizes[p][0]) *
                           static_cast<std::size_t>(earlier_.model.page_sizes[p][1]);
    files_.begin(all);
    PagesBeside kept = keep_pages(from_, run_.input, earlier_.model, change_, run_.settings, files_);
    std::ranges::move(kept.images, beside_.images.begin());
    std::ranges::move(kept.samples, beside_.samples.begin());
  }
  std::future<void> take_model(const io::TexturedModel& made) override {
    model_ = joined(earlier_.model, change_, made);
    return files_.take_model(model_);
  }
  void take_page(std::size_t number, Image page) override {
    files_.take_page(change_.pages_kept + number, std::move(page));
  }
  void take_samples(std::size_t number, atlas::PageSamples page, const BandSet& bands) override {
    files_.take_samples(change_.pages_kept + number, std::move(page), bands);
  }

  io::TexturedModel take_joined() { return std::move(model_); }

  /// Layers lie on all pages, those that are kept and those that were made.
  void bake_onto(const io::TexturedModel& model, std::span<const std::array<int, 2>> page_sizes,
                 std::span<const ViewId> labels, std::span<const LayerPhotos> layers, OutputFolder& folder) const {
    if (layers.empty()) return;
    const io::UvLayout layout = run_.input.layout != nullptr ? *run_.input.layout : layout_of(model, page_sizes);
    const visibility::CoverageTable coverage = earlier_.coverage.of_partial_faces(earlier_.candidates.tags);
    const std::vector<ShiftField> alignment = alignment_of_views();
    bake_layers(run_, layers,
                {run_.input.mesh,
                 run_.input.scene,
                 run_.photos,
                 earlier_.graph,
                 labels,
                 earlier_.candidates.tags,
                 earlier_.candidates.table,
                 coverage,
                 {},
                 {},
                 nullptr,
                 {},
                 alignment,
                 &layout},
                folder);
  }

 private:
  std::vector<ShiftField> alignment_of_views() const {
    std::vector<ShiftField> alignment = earlier_.model.alignment;
    alignment.resize(run_.input.scene.views.size());  // photos that fit each other without stay as they are
    return alignment;
  }

  visibility::CoverageTable coverage_of_made() const {
    std::vector<labeling::FaceTag> tags = earlier_.candidates.tags;
    for (std::size_t f = 0; f < tags.size(); ++f)
      if (change_.kept[f] != 0) tags[f] = labeling::FaceTag::seen;
    return earlier_.coverage.of_partial_faces(tags);
  }

  atlas::TextureAtlas copied() {
    run_.observer.begin({"bake"});
    begin({});
    model_ = earlier_.model.model;
    model_.mesh = &run_.input.mesh;
    if (run_.input.layout != nullptr) model_.obj_texcoords = run_.input.layout->obj_texcoords;
    files_.take_model(model_).get();
    run_.observer.end("nothing to make");
    return {};
  }

  const fs::path& from_;
  const Run& run_;
  const Earlier& earlier_;
  const Change& change_;
  ModelFiles& files_;
  PagesBeside beside_;
  io::TexturedModel model_;
};

labeling::Reselection choose_again(const Earlier& earlier, const Settings& settings, Observer& observer) {
  observer.begin({"choose", "sweeps", true});
  labeling::Reselection again = labeling::reselect_views(earlier.candidates.table, earlier.graph, settings.solver,
                                                         observer.reporter(), earlier.model.labels, earlier.changed);
  report_selection(again.selection, "", observer);
  return again;
}

TexturedFiles remade_into(const fs::path& from, const Run& run, OutputFolder& folder,
                          std::span<const LayerPhotos> layers) {
  const Clock::time_point start = Clock::now();
  const auto& [input, settings, photos, observer, kept] = run;
  Earlier earlier = read_earlier(from, run);
  earlier.graph = weighed_graph(input.mesh, settings.edge_weights, observer);
  labeling::Reselection again = choose_again(earlier, settings, observer);
  release_freed_memory();
  Change change = find_change(earlier.model, earlier.changed, again.selection.labels);
  if (input.layout != nullptr) change = on_given_places(std::move(change));
  ModelFiles files(run, folder, again.selection.labels, earlier.candidates.tags);
  Remaking remaking(from, run, earlier, change, files);
  atlas::TextureAtlas made = remaking.make(again.selection.labels, folder);
  observer.begin({"write"});
  copy_edit_views(from, earlier.model.keys, folder);
  made.model = remaking.take_joined();
  // Only the cuts of new charts were measured: a picture of them would pass for one of all.
  const WrittenModel written = files.finish(made.model, {});
  observer.end("");
  remaking.bake_onto(made.model, files.page_sizes(), again.selection.labels, layers, folder);
  observer.begin({"write"});
  write_edit_model(
      input,
      joined_edit_model(earlier.model, settings, change, again.selection.labels, made.model, made, files.page_sizes()),
      settings.output.texture, folder);
  observer.end("");
  report_change(change, again.free_faces, made.statistics, seconds_since(start), observer);
  return {{std::move(again.selection), std::move(earlier.candidates.tags), std::move(made), {}}, written};
}

}  // namespace

TexturedFiles retexture_into(const fs::path& from, const Run& run, OutputFolder& folder,
                             std::span<const LayerPhotos> layers) {
  checks::validate(run.input);
  check_band_formats(run, layers);
  look_at_layout(run);
  try {
    return remade_into(from, run, folder, layers);
  } catch (const std::bad_alloc&) {
    throw_out_of_memory(plan_memory(run.input, run.settings).peak());
  }
}

}  // namespace gpvc::pipeline
