#include "app/pipeline/keys.h"

#include <tbb/parallel_for.h>

#include <vector>

#include "app/pipeline/options.h"
#include "io/tie_points.h"

namespace gpvc::pipeline {
namespace {

void add_mesh(io::WorkHash& hash, const Mesh& mesh) {
  hash.add(mesh.positions);
  hash.add(mesh.faces);
}

// What the view's name and files are called does not matter.
void add_view(io::WorkHash& hash, const View& view) {
  hash.add(view.pose);
  hash.add(view.camera);
}

// The keys of the views' photos; nullopt for those of unknown bytes.
std::vector<std::optional<io::WorkKey>> photo_keys(const Run& run) {
  std::vector<std::optional<io::WorkKey>> keys(run.input.views.size());
  tbb::parallel_for(std::size_t{0}, keys.size(), [&](std::size_t n) {
    run.observer.check_cancelled();
    keys[n] = run.photos.key(run.input.views[n]);
  });
  return keys;
}

// Of what all parts come from. nullopt if this program cannot be read.
std::optional<io::WorkKey> common_key(const Run& run) {
  io::WorkHash hash;
  try {
    hash.add_file("/proc/self/exe");
  } catch (const InputError&) {
    return std::nullopt;
  }
  if (const auto tie_points = io::tie_points_file(run.input.scene)) hash.add_file(*tie_points);
  add_mesh(hash, run.input.mesh);
  add_options(hash, run.settings, Affects::views);
  return hash.key();
}

}  // namespace

std::optional<StepKeys> step_keys(const Run& run) {
  const std::optional<io::WorkKey> common = common_key(run);
  if (!common) return std::nullopt;
  StepKeys keys;
  io::WorkHash labels;
  for (std::size_t n = 0; const std::optional<io::WorkKey>& photo : photo_keys(run)) {
    if (!photo) return std::nullopt;
    const ViewId id = run.input.views[n++];
    io::WorkHash hash;
    hash.add(*common);
    hash.add(*photo);
    add_view(hash, run.input.scene.views[index(id)]);
    keys.views[id] = hash.key();
    labels.add(id);
    labels.add(hash.key());
  }
  add_options(labels, run.settings, Affects::labels);
  for (const ViewRule& rule : run.settings.view_rules) {  // whatever they are called
    labels.add(rule.region);
    labels.add(rule.allow);
    labels.add(rule.views);
  }
  keys.labels = labels.key();
  io::WorkHash pages;
  pages.add(keys.labels);
  add_options(pages, run.settings, Affects::pages);
  keys.pages = pages.key();
  return keys;
}

ResultKeys result_keys(const Run& run) {
  io::WorkHash mesh, views, options;
  add_mesh(mesh, run.input.mesh);
  for (std::size_t n = 0; const std::optional<io::WorkKey>& photo : photo_keys(run)) {
    const ViewId id = run.input.views[n++];
    views.add(id);
    views.add(photo.value_or(io::WorkKey{}));
    add_view(views, run.input.scene.views[index(id)]);
  }
  add_options(options, run.settings, Affects::page_files);
  return {mesh.key(), views.key(), options.key()};
}

}  // namespace gpvc::pipeline
