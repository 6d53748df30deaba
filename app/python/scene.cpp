#include "app/python/scene.h"

#include <tbb/task_arena.h>

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>

#include "app/python/worker.h"
#include "io/images.h"
#include "io/lens_terms.h"
#include "io/mesh.h"
#include "io/scene_files.h"
#include "io/validate.h"

namespace gpvc::python {
namespace {

namespace fs = std::filesystem;
using Array = py::array_t<double, py::array::c_style>;

Samples samples_from(const py::array& array, const BandSet& bands) {
  Samples samples{
      static_cast<int>(array.shape(1)), static_cast<int>(array.shape(0)), bands.bands.size(), bands.type, {}};
  const auto* bytes = static_cast<const std::byte*>(array.data());
  samples.bytes.assign(bytes, bytes + array.nbytes());
  return samples;
}

io::Picture picture_from(const py::object& pictures, std::uint32_t view, const std::optional<BandSet>& bands) {
  const auto made = pictures.attr("picture")(view).cast<py::tuple>();
  if (bands) {
    Samples samples = samples_from(made[0].cast<py::array>(), *bands);
    std::optional<io::PhotoExclusion> excluded = exclusion_from(made[1]);
    const py::gil_scoped_release unlocked;
    Image image = io::picture_of(samples, *bands);
    return {std::move(image), std::move(excluded), std::move(samples)};
  }
  const auto rgb = made[0].cast<py::array_t<std::uint8_t>>();
  const auto height = static_cast<int>(rgb.shape(0)), width = static_cast<int>(rgb.shape(1));
  const std::span<const std::uint8_t> bytes(rgb.data(), static_cast<std::size_t>(rgb.size()));
  return {{width, height, 3, Pixels::borrowed(bytes, shared_object(rgb))}, exclusion_from(made[1])};
}

// What a function of the caller's makes. It may take as long as it likes and use gpvc itself: meanwhile this thread takes up no
// task that waits for the picture.
class PictureLoader {
 public:
  PictureLoader(std::shared_ptr<const py::object> pictures, std::vector<std::uint32_t> numbers,
                std::optional<BandSet> bands)
      : pictures_(std::move(pictures)), numbers_(std::move(numbers)), bands_(std::move(bands)) {}
  io::Picture operator()(ViewId view) const {
    const std::size_t number = index(view);
    return tbb::this_task_arena::isolate([&] {
      const py::gil_scoped_acquire lock;
      return picture_from(*pictures_, numbers_.empty() ? static_cast<std::uint32_t>(number) : numbers_[number], bands_);
    });
  }

 private:
  std::shared_ptr<const py::object> pictures_;
  std::vector<std::uint32_t> numbers_;
  std::optional<BandSet> bands_;
};

Distortion lens_from(const std::string& model, const py::dict& terms) {
  Distortion lens;
  const auto* named = std::ranges::find_if(kLensModelNames, [&](const auto& known) { return model == known.name; });
  if (named == std::end(kLensModelNames) || is_spherical(named->value))
    throw py::value_error("distortion: there is no lens model '" + model + "'");
  lens.model = named->value;
  for (const auto& [name, value] : terms) {
    const auto word = name.cast<std::string>();
    const auto known = terms_of(lens.model);
    const auto term = std::ranges::find_if(known, [&](const LensTerm& t) { return word == t.name; });
    if (term == known.end()) throw py::value_error("distortion: model '" + model + "' has no term '" + word + "'");
    lens.*term->term = value.cast<double>();
  }
  return lens;
}

// x_camera = rotation * x_world + t.
Pose pose_from(const double* rotation, const double* t) {
  Pose pose;
  std::copy_n(rotation, 9, pose.rotation.begin());
  const auto along = [&](std::size_t axis) {
    return -(rotation[axis] * t[0] + rotation[3 + axis] * t[1] + rotation[6 + axis] * t[2]);
  };
  pose.centre = {along(0), along(1), along(2)};
  return pose;
}

struct Cameras {
  std::vector<std::string> names, photos, masks;  // masks: empty where there is none
  py::array_t<int, py::array::c_style> sizes;     // (N, 2): width, height
  Array intrinsics;                               // (N, 4): fx, fy, cx, cy
  std::vector<std::pair<std::string, py::dict>> lenses;
  Array rotations, translations;  // (N, 3, 3), (N, 3)
};

PhotoScene scene_of(const Cameras& cameras, py::object pictures) {
  auto scene = std::make_shared<Scene>();
  scene->source = "images";
  scene->format = "arrays";
  for (std::size_t v = 0; v < cameras.names.size(); ++v) {
    View view{cameras.names[v], cameras.photos[v], {}, {}, cameras.masks[v]};
    view.camera.width = cameras.sizes.data()[2 * v];
    view.camera.height = cameras.sizes.data()[2 * v + 1];
    const double* const k = cameras.intrinsics.data() + 4 * v;
    std::tie(view.camera.fx, view.camera.fy, view.camera.cx, view.camera.cy) = std::tuple(k[0], k[1], k[2], k[3]);
    view.camera.distortion = lens_from(cameras.lenses[v].first, cameras.lenses[v].second);
    limit_distortion(view.camera);
    view.pose = pose_from(cameras.rotations.data() + 9 * v, cameras.translations.data() + 3 * v);
    if (!view.photo.empty()) {
      view.uses_alpha = io::hides_pixels(view.photo);
      view.exposure_value = io::read_exposure_value(view.photo);
    }
    view.number = static_cast<std::uint32_t>(v);
    validate(view);
    scene->views.push_back(std::move(view));
  }
  return {std::move(scene), shared_object(std::move(pictures))};
}

PhotoScene read(const std::string& source, const py::dict& options) {
  io::SceneOptions reader;
  const auto path = [&](const char* name) -> std::optional<fs::path> {
    if (!options.contains(name) || options[name].is_none()) return std::nullopt;
    return fs::path(options[name].cast<std::string>());
  };
  reader.images_dir = path("images");
  reader.masks_dir = path("masks");
  reader.masks = options["use_masks"].cast<bool>();
  reader.skip_bad_photos = options["skip_bad_photos"].cast<bool>();
  reader.downscale = options["downscale"].cast<int>();
  reader.allow_missing_photos = options["allow_missing_photos"].cast<bool>();
  reader.bands_by_name = options["bands_by_name"].cast<bool>();
  for (const auto& [name, folder] : options["bands"].cast<std::vector<std::pair<std::string, std::string>>>())
    reader.bands.push_back({name, folder});
  reader.composite = options["composite"].cast<std::vector<std::string>>();
  const auto scene = std::make_shared<Scene>();
  Worker().call([=] { *scene = io::read_scene(source, reader); }, cancel_flag());
  return {scene, shared_object(py::none())};
}

py::dict lens_dict(const Distortion& lens) {
  py::dict terms;
  terms["model"] = name_of(kLensModelNames, lens.model);
  for (const LensTerm& term : terms_of(lens.model))
    if (lens.*term.term != 0) terms[term.name] = lens.*term.term;
  return terms;
}

py::dict view_dict(const View& view) {
  const Camera& c = view.camera;
  const auto& r = view.pose.rotation;
  const WorldPoint& centre = view.pose.centre;
  Array k({3, 3}), pose({3, 4});
  std::copy_n(std::array{c.fx, 0., c.cx, 0., c.fy, c.cy, 0., 0., 1.}.begin(), 9, k.mutable_data());
  for (std::size_t row = 0; row < 3; ++row) {
    double* const to = pose.mutable_data() + 4 * row;
    std::copy_n(r.begin() + static_cast<std::ptrdiff_t>(3 * row), 3, to);
    to[3] = -(to[0] * centre.x + to[1] * centre.y + to[2] * centre.z);
  }
  py::dict d;
  d["name"] = view.name;
  d["photo"] = view.photo.string();
  d["mask"] = view.mask.string();
  d["width"] = c.width;
  d["height"] = c.height;
  d["K"] = k;
  d["camera_from_world"] = pose;
  d["centre"] = py::make_tuple(centre.x, centre.y, centre.z);
  d["distortion"] = lens_dict(c.distortion);
  return d;
}

py::tuple read_mesh(const std::string& file) {
  const auto mesh = std::make_shared<Mesh>();
  Worker().call([=] { *mesh = io::read_mesh(file); }, cancel_flag());
  const auto vertices = static_cast<py::ssize_t>(mesh->positions.size()),
             faces = static_cast<py::ssize_t>(mesh->faces.size());
  const auto polygons = static_cast<py::ssize_t>(mesh->source_face.size());
  return py::make_tuple(array_over<double>(std::move(mesh->positions), {vertices, 3}),
                        array_over<std::uint32_t>(std::move(mesh->faces), {faces, 3}),
                        array_over<std::uint32_t>(std::move(mesh->source_face), {polygons}), mesh->warnings);
}

}  // namespace

std::optional<io::PhotoExclusion> exclusion_from(const py::object& excluded) {
  if (excluded.is_none()) return std::nullopt;
  const auto flags = excluded.cast<py::array_t<bool, py::array::c_style | py::array::forcecast>>();
  io::PhotoExclusion made{static_cast<int>(flags.shape(1)), static_cast<int>(flags.shape(0)), 0, {}};
  const auto width = static_cast<std::size_t>(made.width), height = static_cast<std::size_t>(made.height);
  made.stride = (width + 63) / 64;
  made.words.resize(made.stride * height);
  const bool* flag = flags.data();
  for (std::size_t y = 0; y < height; ++y)
    for (std::size_t x = 0; x < width; ++x)
      if (*flag++) made.words[y * made.stride + x / 64] |= std::uint64_t{1} << (x % 64);
  return made;
}

std::unique_ptr<io::PhotoSource> PhotoScene::photos(const Scene& views, std::vector<std::uint32_t> numbers) const {
  if (pictures->is_none()) return std::make_unique<io::PhotoCache>(views);
  return std::make_unique<io::CallbackSource>(views, PictureLoader(pictures, std::move(numbers), views.bands));
}

void bind_scene(py::module_& module) {
  py::class_<PhotoScene>(module, "Scene")
      .def_static("of_cameras",
                  [](std::vector<std::string> names, std::vector<std::string> photos, std::vector<std::string> masks,
                     const py::array_t<int, py::array::c_style>& sizes, const Array& intrinsics,
                     std::vector<std::pair<std::string, py::dict>> lenses, const Array& rotations,
                     const Array& translations, py::object pictures) {
                    return scene_of({std::move(names), std::move(photos), std::move(masks), sizes, intrinsics,
                                     std::move(lenses), rotations, translations},
                                    std::move(pictures));
                  })
      .def_static("read", &read)
      .def("with_pictures",
           [](const PhotoScene& scene, py::object pictures) {
             // Photos are those of `pictures` alone, whose masks count.
             auto bare = std::make_shared<Scene>(*scene.scene);
             bare->bands.reset();
             bare->band_places.clear();
             for (View& view : bare->views) {
               view.photo = view.mask = fs::path{};
               view.band_files.clear();
               view.band_cameras.clear();
               view.uses_alpha = false;
               view.reduction = 1;
             }
             return PhotoScene{std::move(bare), shared_object(std::move(pictures))};
           })
      .def("with_bands",
           [](const PhotoScene& scene, const std::vector<std::string>& names, const std::string& type,
              const std::vector<std::string>& composite, const py::array_t<float, py::array::c_style>& some) {
             auto with = std::make_shared<Scene>(*scene.scene);
             std::vector<Band> bands;
             for (const std::string& name : names) bands.push_back({name});
             const auto* named = std::ranges::find_if(kSampleTypeNames, [&](const auto& n) { return type == n.name; });
             with->bands =
                 io::band_set_of(std::move(bands), named->value, composite, {some.data(), some.data() + some.size()});
             return PhotoScene{std::move(with), scene.pictures};
           })
      .def_property_readonly("bands",
                             [](const PhotoScene& scene) {
                               std::vector<std::string> names;
                               if (scene.scene->bands)
                                 for (const Band& band : scene.scene->bands->bands) names.push_back(band.name);
                               return names;
                             })
      .def("views",
           [](const PhotoScene& scene) {
             py::list views;
             for (const View& view : scene.scene->views) views.append(view_dict(view));
             return views;
           })
      .def_property_readonly("format", [](const PhotoScene& scene) { return scene.scene->format; })
      .def_property_readonly("srs", [](const PhotoScene& scene) { return scene.scene->srs; })
      .def_property_readonly("warnings", [](const PhotoScene& scene) { return scene.scene->warnings; })
      .def_property_readonly("has_pictures", [](const PhotoScene& scene) { return !scene.pictures->is_none(); });
  module.def("read_mesh", &read_mesh);
  module.def("hides_pixels", [](const std::string& file) { return io::hides_pixels(file); });
  module.def("image_size", [](const std::string& file) {
    const io::ImageSize size = io::read_image_size(file);
    return std::pair(size.width, size.height);
  });
  // What PhotoCache gives of a photo in a file, for scenes some of whose pictures are in memory.
  module.def("read_photo", [](const std::string& photo, const std::string& mask) {
    View view{"", photo, {}, {}, mask};
    const io::ImageSize size = photo.empty() ? io::read_image_size(mask) : io::read_image_size(photo);
    view.camera.width = size.width;
    view.camera.height = size.height;
    view.uses_alpha = !photo.empty() && io::hides_pixels(photo);
    Image image;
    std::optional<io::PhotoExclusion> excluded;
    {
      const py::gil_scoped_release unlocked;
      if (!photo.empty()) image = io::read_image(photo);
      if (view.uses_alpha || !mask.empty()) excluded = io::read_exclusion(view);
    }
    py::object rgb = py::none(), flags = py::none();
    if (!photo.empty()) rgb = array_over<std::uint8_t>(image.pixels.release(), {size.height, size.width, 3});
    if (excluded) {
      std::vector<std::uint8_t> bytes;
      for (int y = 0; y < size.height; ++y)
        for (int x = 0; x < size.width; ++x) bytes.push_back(excluded->excludes(x, y) ? 1 : 0);
      flags = array_over<std::uint8_t>(std::move(bytes), {size.height, size.width}).attr("view")("bool");
    }
    return py::make_tuple(rgb, flags);
  });
}

}  // namespace gpvc::python
