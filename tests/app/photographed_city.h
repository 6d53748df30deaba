// A small generated city and six photos of it, in memory and as files.
#pragma once

#include <string>
#include <vector>

#include "app/pipeline/pipeline.h"
#include "app/synth/city.h"
#include "io/images.h"
#include "tests/support/temporary_folder.h"

namespace gpvc::test {

struct City {
  explicit City(std::size_t faces = 4000, int width = 240, int photos = 6) {
    synth::FlightOptions flight;
    flight.photos = photos;
    flight.width = width;
    flight.height = width / 3 * 2;
    flight.size_m = 50;
    synth::SynthScene made = synth::make_city({flight, faces});
    synth::SynthRenderer renderer(made);
    scene.views = synth::synth_flight(flight);
    for (View& view : scene.views) {
      view.photo = folder.path() / (std::to_string(pictures.size()) + ".png");
      pictures.push_back({renderer.photo(view.camera, view.pose).image});
      io::write_image(view.photo, pictures.back().image, io::ImageFormat::png, 0);
    }
    mesh = std::move(made.mesh);
    views = checks::all_views(scene);
  }
  TemporaryFolder folder;
  Scene scene;
  Mesh mesh;
  std::vector<io::Picture> pictures;
  std::vector<ViewId> views;
};

}  // namespace gpvc::test
