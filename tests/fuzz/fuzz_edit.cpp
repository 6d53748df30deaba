#include "app/pipeline/edit_files.h"
#include "app/pipeline/pipeline.h"
#include "io/photos.h"
#include "tiny.h"

namespace gpvc::fuzz {
namespace {

namespace fs = std::filesystem;

constexpr const char* kEditFiles[] = {pipeline::kEditModelFile, pipeline::kEditViewsFile};

pipeline::Settings edit_settings() {
  pipeline::Settings settings = tiny_settings();
  settings.editable = true;
  return settings;
}

void texture_editable(const pipeline::Settings& chosen, const fs::path& from, const fs::path& out, bool keep) {
  io::PhotoCache photos(tiny().scene);
  results::Observer silent;
  results::OutputFolder folder(out, true, "texture");
  const checks::Input input = tiny().input();
  if (from.empty())
    pipeline::texture_into({input, chosen, photos, silent}, folder);
  else
    pipeline::retexture_into(from, {input, chosen, photos, silent}, folder);
  if (keep) folder.publish();
}

const fs::path& editable() {
  static const fs::path kResult = [] {
    fs::path out = folder() / "editable";
    texture_editable(edit_settings(), {}, out, true);
    return out;
  }();
  return kResult;
}

std::vector<std::string> edit_seeds(const fs::path&) {
  std::vector<std::string> seeds;
  for (std::size_t n = 0; n < std::size(kEditFiles); ++n)
    seeds.push_back(input_for(n, stored(editable() / kEditFiles[n])));
  return seeds;
}

}  // namespace

// The files of an editable result, which other rules change.
GPVC_FUZZ_TARGET(edit, edit_seeds) {
  const Choice choice = choice_of(view(data, size), std::size(kEditFiles));
  static const Snapshot kGood(editable());
  store(editable() / kEditFiles[choice.number], choice.body, pipeline::kEditHashesFile);
  pipeline::Settings other = edit_settings();
  other.view_rules = {{io::GroundRegion{{{0, -3}, {3, -3}, {3, 3}, {0, 3}}}, false, {ViewId{1}}, "rule"}};
  succeeds_or_fails([&] { texture_editable(other, editable(), folder() / "changed", false); });
  kGood.restore();
  return 0;
}

}  // namespace gpvc::fuzz
