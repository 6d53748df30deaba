#include "app/python/save.h"

#include <tbb/parallel_for.h>
#include <unistd.h>

#include <cstddef>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "app/pipeline/given_layout.h"
#include "app/pipeline/texture_files.h"
#include "app/pipeline/web_model.h"

namespace gpvc::python {
namespace {

namespace fs = std::filesystem;

// A folder beside the files to be written, in which they are until all are complete.
class Staging {
 public:
  explicit Staging(const fs::path& model) : target_(fs::absolute(model).parent_path()) {
    std::string name = (target_ / ("." + model.filename().string() + ".XXXXXX")).string();
    if (mkdtemp(name.data()) == nullptr)
      throw OutputError(model, std::error_code(errno, std::generic_category()).message());
    folder_ = name;
  }
  ~Staging() {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
  }
  Staging(const Staging&) = delete;
  Staging& operator=(const Staging&) = delete;

  const fs::path& folder() const { return folder_; }
  void publish(const fs::path& name) const {
    std::error_code failed;
    fs::rename(folder_ / name, target_ / name, failed);
    if (failed) throw OutputError(target_ / name, failed.message());
  }

 private:
  fs::path target_, folder_;
};

struct Writer {
  const pipeline::Run& run;
  const TextureResult& result;
  const io::ModelOptions options;

  std::vector<io::PageFile> write_pages(const fs::path& stem) const {
    const std::vector<Image>& pages = result.textured.atlas.pages;
    const pipeline::OutputSettings& output = run.settings.output;
    const io::ColorProfile profile = pipeline::profile_of_photos(run);
    std::vector<io::PageFile> files;
    for (std::size_t n = 0; n < pages.size(); ++n) {
      files.push_back(
          {stem.string() + pipeline::page_suffix(run.input, n) + "." + name_of(io::kImageFormatNames, output.texture),
           output.texture});
      if (run.input.layout != nullptr) files.back().material = run.input.layout->pages[n].material;
    }
    tbb::parallel_for(std::size_t{0}, pages.size(), [&](std::size_t n) {
      run.observer.check_cancelled();
      io::write_image(files[n].file, pages[n], output.texture, output.quality, profile);
    });
    return files;
  }

  // Beside the pages, where photos have bands.
  std::vector<fs::path> write_samples(const std::vector<io::PageFile>& pages) const {
    const std::vector<atlas::PageSamples>& samples = result.textured.atlas.samples;
    std::vector<fs::path> files;
    for (std::size_t n = 0; n < samples.size(); ++n) {
      run.observer.check_cancelled();
      files.push_back(pipeline::samples_of(pages[n].file, run.settings.output.band_format));
      io::write_samples(files.back(), samples[n].samples, *result.scene.bands, samples[n].charts);
    }
    return files;
  }

  std::vector<fs::path> write_obj(const fs::path& stem) const {
    std::vector<fs::path> written;
    const std::vector<io::PageFile> pages = write_pages(stem);
    for (const io::PageFile& page : pages) written.push_back(page.file.filename());
    for (const fs::path& samples : write_samples(pages)) written.push_back(samples.filename());
    const fs::path folder = stem.parent_path();
    if (pipeline::has_offset(options)) {
      pipeline::write_offset(options, folder / pipeline::kOffsetFile);
      written.emplace_back(pipeline::kOffsetFile);
    }
    if (!options.srs.empty()) {
      pipeline::write_metadata(options, folder / pipeline::kMetadataFile);
      written.emplace_back(pipeline::kMetadataFile);
    }
    const std::string name = stem.filename().string();
    io::write_obj(folder / (name + ".obj"), result.textured.atlas.model, pages, options);
    written.emplace_back(name + ".mtl");
    written.emplace_back(name + ".obj");
    return written;
  }

  std::vector<fs::path> write_gltf(const fs::path& stem, io::GltfContainer container) const {
    const std::vector<io::PageFile> pages = write_pages(stem);
    const io::TexturedModel shown =
        pipeline::without_dropped(result.textured.atlas.model, result.textured.tags, run.settings.atlas.unseen);
    std::vector<fs::path> written;
    io::GltfFiles made;
    if (run.settings.output.target == pipeline::Target::web) {
      const pipeline::WebModel web = pipeline::write_web_model(run, stem, shown, pages, options);
      made = web.files;
      if (!made.buffers.empty())
        for (const fs::path& page : web.pages.written) written.push_back(page.filename());
    } else {
      made = io::write_gltf(stem, container, shown, pages, options);
    }
    if (!made.buffers.empty())
      for (const io::PageFile& page : pages) written.push_back(page.file.filename());
    for (const fs::path& buffer : made.buffers) written.push_back(buffer.filename());
    written.push_back(made.file.filename());
    return written;
  }
};

}  // namespace

void save(const TextureResult& result, const fs::path& path, results::Observer& observer) {
  const pipeline::Input input = result.input();
  const fs::path extension = path.extension();
  pipeline::Settings settings = result.settings;
  if (extension == ".gltf") settings.output.gltf = io::GltfContainer::files;
  if (extension == ".glb") settings.output.gltf = io::GltfContainer::glb;
  io::CallbackSource unused(result.scene, [](ViewId) { return io::Picture{}; });
  const pipeline::Run run{input, settings, unused, observer};
  if (extension.empty()) {
    results::OutputFolder folder(path);
    pipeline::write(run, result.textured, folder);
    folder.publish();
    return;
  }
  const Staging staging(path);
  const fs::path stem = staging.folder() / path.stem();
  const Writer writer{run, result, pipeline::model_options(input, result.textured.selection.labels, settings.output)};
  const std::vector<fs::path> written =
      extension == ".obj" ? writer.write_obj(stem) : writer.write_gltf(stem, settings.output.gltf);
  for (const fs::path& name : written) staging.publish(name);
}

}  // namespace gpvc::python
