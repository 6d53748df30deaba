// Textures a scene with pictures that it holds in memory: outsider SCENE MESH OUT.
#include <gpvc/app/pipeline/pipeline.h>
#include <gpvc/io/images.h>
#include <gpvc/io/mesh.h>
#include <gpvc/io/scene_files.h>

int main(int, char** argv) {
  using namespace gpvc;
  const Scene scene = io::read_scene(argv[1], {});
  const Mesh mesh = io::read_mesh(argv[2]);
  std::vector<io::Picture> pictures;
  for (const View& view : scene.views) pictures.push_back({io::read_image(view.photo)});
  io::PictureSource photos(scene, std::move(pictures));

  const pipeline::Settings settings;
  results::Observer silent;
  const pipeline::TexturedMesh textured = pipeline::texture(scene, mesh, settings, photos, silent);
  results::OutputFolder folder(argv[3], false, "outsider");
  const std::vector<ViewId> views = checks::all_views(scene);
  pipeline::write({scene, mesh, views}, textured, settings, folder, silent);
  folder.publish();
}
