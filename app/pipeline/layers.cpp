#include "app/pipeline/layers.h"

#include <fmt/format.h>

#include <filesystem>
#include <stdexcept>
#include <utility>

#include "app/pipeline/bake_into.h"
#include "app/pipeline/given_layout.h"
#include "app/pipeline/texture_files.h"
#include "io/images.h"

namespace gpvc::pipeline {
namespace {

namespace fs = std::filesystem;

/// Hears all of a layer but the figures and notes that the model has of the same name.
class LayerObserver final : public Observer {
 public:
  explicit LayerObserver(Observer& all) : all_(all) {}
  void begin(const results::StageInfo& stage) override { all_.begin(stage); }
  void progress(std::size_t done, std::size_t total) override { all_.progress(done, total); }
  void end(const std::string& summary) override { all_.end(summary); }
  void detail(const std::string& text) override { all_.detail(text); }
  void warning(const std::string& text, const std::vector<Cure>& cures) override { all_.warning(text, cures); }
  void stage_figure(const std::string& name, const results::Figure& value) override { all_.stage_figure(name, value); }
  void check_cancelled() override { all_.check_cancelled(); }

 private:
  Observer& all_;
};

/// Pages of a layer as files.
class LayerFiles final : public PageSink {
 public:
  LayerFiles(const Run& run, const fs::path& inside, OutputFolder& folder)
      : run_(run), inside_(inside), folder_(folder), profile_(profile_of_photos(run)) {}

  void begin(const atlas::AtlasEstimate& size) override {
    for (std::size_t n = 0; n < size.pages; ++n) {
      const fs::path page = inside_ / page_file_name(run_.input, n, run_.settings.output.texture);
      pages_.push_back(folder_.file(page));
      if (run_.input.scene.bands) samples_.push_back(folder_.file(samples_of(page, run_.settings.output.band_format)));
    }
  }
  void take_page(std::size_t number, Image page) override {
    const OutputSettings& output = run_.settings.output;
    io::write_image(pages_[number], page, output.texture, output.quality, profile_);
  }
  void take_samples(std::size_t number, atlas::PageSamples page, const BandSet& bands) override {
    io::write_samples(samples_[number], page.samples, bands, page.charts);
  }

 private:
  const Run& run_;
  fs::path inside_;
  OutputFolder& folder_;
  io::ColorProfile profile_;
  std::vector<fs::path> pages_, samples_;
};

void bake_layer(const Run& run, const LayerPhotos& layer, const atlas::AtlasInput& from, OutputFolder& folder) {
  Settings settings = run.settings;
  if (!layer.leveled) {
    settings.atlas.seams = atlas::SeamLeveling::none;
    settings.atlas.blend = atlas::Blending::none;
  }
  if (from.layout != nullptr) {  // which has met the limits
    settings.atlas.max_pages = 0;
    settings.atlas.max_texels = 0;
    settings.atlas.texel_size = 0;
  }
  const Input input{layer.scene, run.input.mesh, run.input.views, run.input.mesh_file, run.input.layout};
  const double whole = plan_memory(run.input, run.settings).limit;
  const MemoryPlan memory = plan_baking(input, settings, from.coverage, whole);
  LayerObserver observer(run.observer);
  const Run bare{input, settings, layer.photos, observer};
  io::CoarsePhotos photos = with_coarse_photos(bare, memory.work, 0, folder.in_making());
  const Run of_layer{input, settings, photos, observer};
  const atlas::AtlasInput layer_from{from.mesh,       layer.scene,   photos, from.graph, from.labels, from.tags,
                                     from.candidates, from.coverage, {},     {},         nullptr,     {},
                                     from.alignment,  from.layout};
  LayerFiles files(of_layer, fs::path("layers") / layer.name, folder);
  const BakeSpace space{.stage = "bake " + layer.name, .scratch_folder = folder.in_making(), .kept = {}};
  bake_into(of_layer, layer_from, memory, space, &files);
  layer.photos.keep_at_most(0);
}

}  // namespace

void check_band_formats(const Run& run, std::span<const LayerPhotos> layers) {
  check_band_format(run.input, run.settings.output);
  for (const LayerPhotos& layer : layers)
    check_band_format({layer.scene, run.input.mesh, run.input.views}, run.settings.output);
}

void check_layer(const Input& input, const std::string& name, const Scene& layer) {
  if (layer.views.size() != input.scene.views.size())
    throw InputError(name, "",
                     fmt::format("{} views have photos in this layer, expected {}, one for each of the model's photos",
                                 layer.views.size(), input.scene.views.size()));
  for (const ViewId id : input.views) {
    const View &view = input.scene.views[index(id)], &other = layer.views[index(id)];
    if (view.name != other.name)
      throw InputError(name, "", fmt::format("has {} in the place of {}", other.name, view.name));
    if (view.camera.width != other.camera.width || view.camera.height != other.camera.height)
      throw InputError(other.photo, "",
                       fmt::format("is {} x {} pixels, expected {} x {}, the size of the photo that it lies over",
                                   other.camera.width, other.camera.height, view.camera.width, view.camera.height));
  }
}

void bake_layers(const Run& run, std::span<const LayerPhotos> layers, const atlas::AtlasInput& from,
                 OutputFolder& folder) {
  for (const LayerPhotos& layer : layers) bake_layer(run, layer, from, folder);
}

io::UvLayout layout_of(const io::TexturedModel& model, std::span<const std::array<int, 2>> page_sizes) {
  io::UvLayout layout;
  layout.texcoords = model.texcoords;
  layout.obj_texcoords = model.obj_texcoords;
  layout.face_texcoords = model.face_texcoords;
  layout.face_page = model.face_page;
  for (std::size_t n = 0; n < page_sizes.size(); ++n)
    layout.pages.push_back({fmt::format("_{}", n), fmt::format("page_{}", n), page_sizes[n][0], page_sizes[n][1]});
  return layout;
}

}  // namespace gpvc::pipeline
