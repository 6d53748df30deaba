// Textures a scene with pictures that it holds in memory: outsider SCENE MESH OUT.
#include <gpvc/gpvc.h>

int main(int, char** argv) {
  using namespace gpvc;
  Scene scene = io::read_scene(argv[1], {});
  Mesh mesh = io::read_mesh(argv[2]);
  std::vector<io::Picture> pictures;
  for (const View& view : scene.views) pictures.push_back({io::read_image(view.photo)});
  io::PictureSource photos(scene, std::move(pictures));

  const pipeline::Settings settings;
  pipeline::Observer silent;
  const pipeline::TexturedMesh textured = pipeline::texture(scene, mesh, settings, photos, silent);
  pipeline::write(scene, mesh, textured, settings, argv[3], silent);
}
