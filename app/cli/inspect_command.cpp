// gpvc inspect: what is understood of the input, and what a run will cost.
#include <fmt/format.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <future>
#include <set>
#include <stdexcept>

#include "app/checks/frame_check.h"
#include "app/cli/band_notes.h"
#include "app/cli/interrupt.h"
#include "app/cli/run_record.h"
#include "app/cli/scene_input.h"
#include "app/evaluate/agreement_picture.h"
#include "app/evaluate/photo_quality.h"
#include "app/evaluate/place.h"
#include "app/pipeline/viewpoint.h"
#include "app/results/output_folder.h"
#include "app/tiles/plan_text.h"
#include "io/images.h"
#include "io/lens_terms.h"
#include "io/mesh.h"
#include "io/output_file.h"
#include "io/reference_system.h"

namespace gpvc::cli {
namespace {

std::string camera_text(const Camera& c) {
  if (c.width == 0) return "size and focal length depend on the photo, which is missing";
  std::string text =
      fmt::format("{} x {} px, fx {:.2f} fy {:.2f} cx {:.2f} cy {:.2f}", c.width, c.height, c.fx, c.fy, c.cx, c.cy);
  const Distortion& d = c.distortion;
  if (d == Distortion{}) return text + ", no distortion";
  text += fmt::format(", {}", name_of(kLensModelNames, d.model));
  const std::string terms = evaluate::lens_text(d);
  return terms.empty() ? text : text + " " + terms;
}

std::string missing_text(const Scene& scene, std::span<const ViewId> used) {
  std::vector<std::string> missing;
  for (const ViewId id : used)
    if (const View& view = scene.views[index(id)]; view.photo.empty()) missing.push_back(view.name);
  if (missing.empty()) return "all photos found";
  return fmt::format("{} photos missing: {}", missing.size(), results::readable_list(missing, 10));
}

/// A system as the scene gives it and what it is called; the name alone where the scene has the whole definition (WKT).
std::string system_text(const std::string& srs) {
  const io::SystemName system = io::system_name(srs);
  std::string text = system.name;
  if (text.empty() || srs.find(text) == std::string::npos) text = srs + (text.empty() ? "" : ", " + text);
  return system.unit.empty() ? text : text + ", in units of a " + system.unit;
}

void print_cameras(const Scene& scene, std::span<const ViewId> used, Console& console) {
  std::vector<std::pair<Camera, std::size_t>> cameras;
  std::size_t moving = 0, aside = 0;
  for (const View& view : scene.views) {
    Camera camera = view.camera;
    if (camera.distortion.looks_aside()) {
      ++aside;
      continue;
    }
    moving += camera.distortion.motion.moves() ? 1 : 0;
    camera.distortion.motion = {};
    const auto known = std::ranges::find(cameras, camera, [](const auto& c) -> const Camera& { return c.first; });
    if (known == cameras.end())
      cameras.emplace_back(camera, 1);
    else
      ++known->second;
  }
  console.result(fmt::format("format   {}", scene.format));
  console.result(fmt::format("views    {}, {}", scene.views.size(), missing_text(scene, used)));
  constexpr std::size_t kMost = 20;
  for (std::size_t i = 0; i < std::min(kMost, cameras.size()); ++i)
    console.result(fmt::format("camera   {} views: {}", cameras[i].second, camera_text(cameras[i].first)));
  if (cameras.size() > kMost) console.result(fmt::format("camera   and {} more", cameras.size() - kMost));
  if (aside > 0) console.result(fmt::format("aside    {} views show what lies beyond the frames of fisheyes", aside));
  if (moving > 0)
    console.result(fmt::format("shutter  {} views moved while they were read out, which is undone row by row", moving));
  for (const std::string& note : band_notes(scene)) console.result("bands    " + note);
  console.result("cameras  " + checks::box_text(checks::box_of(scene)));
  if (!scene.srs.empty()) console.result("srs      " + system_text(scene.srs));
  if (!(scene.offset == WorldPoint{}))
    console.result(
        fmt::format("offset   {} {} {} to be added for the srs", scene.offset.x, scene.offset.y, scene.offset.z));
  for (const std::string& warning : scene.warnings) console.warning(warning);
}

void print_mesh(const SceneInputData& in, Console& console) {
  const Mesh& mesh = in.mesh;
  const std::string source =
      mesh.source_face.empty()
          ? ""
          : fmt::format(" cut from {} polygons", results::readable_count(std::size_t{mesh.source_face.back()} + 1));
  console.result(fmt::format("mesh     {} faces{}, {} vertices", results::readable_count(mesh.faces.size()), source,
                             results::readable_count(mesh.positions.size())));
  const io::MeshTopology topology = io::mesh_topology(mesh);
  console.result(fmt::format(
      "topology {} components, {} boundary edges in {} loops, {} non-manifold faces, {} degenerate faces, {} "
      "unused vertices",
      results::readable_count(topology.components), results::readable_count(topology.boundary_edges),
      results::readable_count(topology.boundary_loops), results::readable_count(topology.nonmanifold_faces),
      results::readable_count(topology.degenerate_faces), results::readable_count(topology.unused_vertices)));
  const io::MeshFlaws flaws = io::mesh_flaws(mesh);
  console.result(
      fmt::format("flaws    {} duplicate faces, {} faces without area, {} duplicate vertices; all are kept in their "
                  "place",
                  results::readable_count(flaws.duplicate_faces),
                  results::readable_count(flaws.flat_faces + flaws.degenerate_faces),
                  results::readable_count(flaws.duplicate_vertices)));
  console.result("extent   " + checks::box_text(checks::box_of(mesh)));
}

void print_estimate(const SceneInputData& in, int threads, Console& console) {
  const pipeline::Settings settings;
  const checks::Input input{in.scene, in.mesh, in.used};
  const pipeline::Workload work = pipeline::workload(input, settings);
  try {
    console.result(fmt::format("estimate about {} of memory and {} on {} threads for gpvc texture",
                               results::readable_bytes(pipeline::plan_memory(input, settings).peak()),
                               results::readable_duration(pipeline::predicted_seconds(work, threads)), threads));
  } catch (const pipeline::MemoryError& error) {
    console.warning(error.what(), error.cures());
  }
}

void print_coverage(const SceneInputData& in, const std::filesystem::path& mesh_file, int threads, Console& console) {
  console.result(fmt::format("in frame {:.1f} % of the faces may lie in some photo's frame (occlusion not looked at)",
                             100 * checks::framed_share(in.mesh, in.scene, in.used)));
  const std::vector<std::size_t> overlap = checks::overlap(in.mesh, in.scene, in.used);
  if (!overlap.empty()) {
    constexpr std::size_t kFew = 3;  // fewer leave no choice between photos, nor a vote on what stands in the way
    const auto few = std::ranges::lower_bound(overlap, kFew) - overlap.begin();
    console.result(fmt::format(
        "overlap  {} photos may show a face in the median, {} .. {} for nine in ten; {:.1f} % of the faces "
        "lie in fewer than {}",
        overlap[overlap.size() / 2], overlap[overlap.size() / 20], overlap[overlap.size() - 1 - overlap.size() / 20],
        100 * static_cast<double>(few) / static_cast<double>(overlap.size()), kFew));
  }
  throw_if_interrupted();
  const std::optional<checks::Backs> backs = checks::back_share(in.mesh, in.scene, in.used);
  throw_if_interrupted();
  if (backs)
    console.result(
        fmt::format("turned   {:.1f} % of what the cameras see of it are backs of faces", 100 * backs->share));
  const std::vector<double> sampling = checks::sampling_distances(in.mesh, in.scene, in.used);
  throw_if_interrupted();
  const std::string unit = io::system_name(in.scene.srs).unit;
  if (!sampling.empty())
    console.result(fmt::format("sampling {:.6g} {} a pixel in the median, {:.6g} .. {:.6g} for nine in ten",
                               sampling[sampling.size() / 2], unit.empty() ? "units" : unit,
                               sampling[sampling.size() / 20], sampling[sampling.size() - 1 - sampling.size() / 20]));
  console.result(fmt::format("up       {}", name_of(io::kUpAxisNames, pipeline::scene_up(in.scene, in.used))));
  print_estimate(in, threads, console);
  try {
    checks::check_frames(in.mesh, mesh_file, in.scene, in.used);
    const std::string warning = checks::check_winding(backs, mesh_file);
    if (!warning.empty()) console.warning(warning);
    const std::string scale = checks::check_scale(in.mesh, sampling, mesh_file);
    if (!scale.empty()) console.warning(scale);
    const std::string lenses = checks::check_lenses(in.scene, in.used);
    if (!lenses.empty()) console.warning(lenses);
  } catch (const InputError& error) {
    console.warning(error.what(), error.cures());
  }
}

const char* verdict_text(const checks::MeshFit& fit, const char* fits, const char* elsewhere) {
  switch (fit.verdict) {
    case checks::MeshFit::Verdict::fits:
      return fits;
    case checks::MeshFit::Verdict::doubtful:
      return "DOUBTFUL";
    case checks::MeshFit::Verdict::elsewhere:
      return elsewhere;
    case checks::MeshFit::Verdict::unknown:
      break;
  }
  return "not judged";
}

// What each photo is worth by itself.
void print_quality(const SceneInputData& in, io::PhotoSource& photos, RunRecord& record, Console& console) {
  std::vector<evaluate::PhotoQuality> qualities(in.used.size());
  record.begin({"photos", "photos"});
  std::atomic<std::size_t> done{0};
  tbb::parallel_for(std::size_t{0}, in.used.size(), [&](std::size_t i) {
    throw_if_interrupted();
    qualities[i] = evaluate::photo_quality(*photos.photo(in.used[i]));
    ++done;
  });
  record.end(fmt::format("{} looked at", done.load()));
  std::vector<std::string> names;
  for (std::size_t i = 0; i < in.used.size(); ++i) {
    names.push_back(in.scene.views[index(in.used[i])].name);
    const evaluate::PhotoQuality& photo = qualities[i];
    console.result(fmt::format("quality  {}: blur {:.1f} px, brightness {:.0f} %, {:.1f} % burnt out", names.back(),
                               photo.blur, 100 * photo.brightness, 100 * photo.clipped));
  }
  for (const std::string& warning : evaluate::quality_warnings(qualities, names)) console.warning(warning);
}

// What the first stage of gpvc texture finds about photos and poses.
void print_agreement(const SceneInputData& in, const InspectOptions& options, Console& console) {
  pipeline::Settings settings;
  settings.costs.keep_odd_views = settings.allow_misfit = settings.allow_unseen =
      true;  // a wrong scene is looked at as a whole
  io::PhotoCache photos(in.scene);
  RunRecord record(console);
  const checks::Input input{in.scene, in.mesh, in.used, options.input.mesh};
  const pipeline::Seen seen = pipeline::see({input, settings, photos, record});
  console.result("photo    agreement with the others (1: same picture), by chance, places compared");
  for (const labeling::ViewAgreement& each : seen.candidates.agreement) {
    const std::string& name = in.scene.views[index(each.view)].name;
    const std::string places = results::readable_count(each.steps);
    if (each.judged)
      console.result(fmt::format("agrees   {}: {:.3f}, {:.3f}, {}{}", name, each.correlation, each.chance, places,
                                 each.by_chance ? ": HARDLY BETTER THAN CHANCE" : ""));
    else
      console.result(fmt::format("agrees   {}: unknown, {} places are too few", name, places));
  }
  console.result(fmt::format("mesh     {}: {}",
                             verdict_text(seen.fit, "fits the photos", "NOT WHERE THE PHOTOS SHOW IT"),
                             checks::photo_fit_text(seen.fit)));
  if (seen.tie_point_fit.places > 0)
    console.result(fmt::format("mesh     {}: {}",
                               verdict_text(seen.tie_point_fit, "fits the tie points", "NOT WHERE THE TIE POINTS LIE"),
                               checks::tie_point_fit_text(seen.tie_point_fit)));
  print_quality(in, photos, record, console);
  if (options.picture.empty()) return;
  constexpr std::size_t kRows = 6;
  const std::vector<evaluate::PairOfViews> pairs = evaluate::least_agreeing(seen.candidates, kRows);
  if (pairs.empty()) throw OutputError(options.picture, "is not written: no photo could be compared with others");
  const Image picture = evaluate::agreement_picture({in.scene, in.mesh, in.used, options.input.mesh},
                                                    seen.candidates.table, pairs, photos);
  io::write_image(options.picture, picture, io::ImageFormat::png, 0);
  for (std::size_t row = 0; row < pairs.size(); ++row)
    console.result(fmt::format("picture  row {}: {}, and what {} shows of the mesh from there", row + 1,
                               in.scene.views[index(pairs[row].view)].name,
                               in.scene.views[index(pairs[row].other)].name));
}

// Throws OutputError if the picture would replace a file that is read, or cannot be written: before photos are compared.
void check_picture(const InspectOptions& options, const Scene& scene) {
  std::set<std::filesystem::path> read = input_files(scene);
  for (const std::filesystem::path& mesh : io::mesh_files(options.input.mesh))
    read.insert(std::filesystem::weakly_canonical(mesh));
  if (read.contains(std::filesystem::weakly_canonical(options.picture)))
    throw OutputError(options.picture, "is a file that is read; choose another name for the picture");
  const io::OutputFile probe(options.picture);
}

void print_place(const InspectOptions& options, Console& console) {
  const std::filesystem::path& out = options.input.scene;
  results::OutputFolder::finish_interrupted(out);
  const evaluate::ShownPlace shown = evaluate::shown_at(out, *options.at);
  const std::vector<std::string> names = listed_views(out / "model.obj");
  if (shown.view != kNoView && index(shown.view) >= names.size())
    throw InputError(out / "views.json", "", fmt::format("names no view {}", index(shown.view)));
  console.result(fmt::format("place    {:.6g} from face {}", shown.distance, shown.face));
  if (shown.view == kNoView)
    console.result("photo    none: the face is filled from around");
  else
    console.result(fmt::format("photo    {}{}", names[index(shown.view)],
                               shown.whole ? "" : ", which shows the face in parts; others may show the rest"));
}

}  // namespace

void run_inspect(const InspectOptions& options, Console& console) {
  const EndsSoonAfterSignal ends([&] { console.interrupted(); });
  if (options.at) return print_place(options, console);
  check_places(options.input);
  if (!options.picture.empty() && !options.check) throw UsageError("--picture belongs to --check");
  if (options.input.mesh.empty() && options.plan)
    throw UsageError("--plan counts what a mesh takes: name one after the scene");
  if (options.input.mesh.empty() && options.check)
    throw UsageError("--check compares what the photos show of a mesh: name one after the scene");
  SceneInputData in;
  std::future<Mesh> mesh;  // read while photos are looked for
  if (!options.input.mesh.empty())
    mesh = std::async(std::launch::async, [&] { return io::read_mesh(options.input.mesh); });
  in.scene = read_views(options.input, in.used, !options.check);
  if (!options.picture.empty()) check_picture(options, in.scene);
  print_cameras(in.scene, in.used, console);
  throw_if_interrupted();
  if (!mesh.valid()) return;
  in.mesh = mesh.get();
  throw_if_interrupted();
  RunRecord record(console);
  for (const std::string& warning : in.mesh.warnings) record.warning(options.input.mesh.string() + ": " + warning);
  checks::match(in.scene, in.mesh, in.used, origin_of(options.input), record);
  print_mesh(in, console);
  throw_if_interrupted();
  const int threads = options.common.threads > 0 ? options.common.threads : tbb::info::default_concurrency();
  print_coverage(in, options.input.mesh, threads, console);
  if (options.plan) {
    const checks::Input input{in.scene, in.mesh, in.used, options.input.mesh};
    const std::vector<tiles::Unit> units = tiles::plan_units(tiles::cut_scene(input, options.job, record));
    console.result("plan of a job of gpvc tiles");
    for (const std::string& line : tiles::plan_table(units)) console.result("  " + line);
  }
  if (options.check) print_agreement(in, options, console);
}

}  // namespace gpvc::cli
