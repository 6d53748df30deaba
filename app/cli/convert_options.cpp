// The options of gpvc convert.
#include "app/cli/command_options.h"
#include "app/cli/option_parts.h"

namespace gpvc::cli {

CLI::App* add_convert(CLI::App& parent, ConvertOptions& options) {
  CLI::App* app = parent.add_subcommand("convert", "write a scene for another program");
  add_scene(*app, options.input);
  add_photos(*app, options.input);
  const OptionGroup input{*app, pipeline::kInput};
  input
      .add(
          "--mesh", options.input.mesh, "MESH",
          "Write the cameras in the coordinates of this mesh, where the scene's program writes meshes in several; with "
          "it, --undistort also undoes how far rolling shutters travelled")
      ->default_str("the cameras' own coordinates");
  add_mesh_crs(input, options.input, "Reference system of that mesh, where cameras are in another");
  add_output(*app, options);
  const OptionGroup output{*app, pipeline::kOutput};
  output.choice("--format", io::kSceneTargetNames, options.target,
                "COLMAP's binary model, mvs-texturing's .cam files, OpenMVS' scene.mvs, transforms.json for nerfstudio "
                "and instant-ngp, OpenSfM's reconstruction.json, or VisualSFM's scene.nvm");
  CLI::Option* undistort =
      output.flag("--undistort", options.undistort,
                  "Write photos without lens distortion, and cameras to match; for nvm with square "
                  "pixels, about the middle of the photo");
  output
      .choice("--frame", pipeline::kFrameRuleNames, options.frame,
              "Extent of undistorted photos, at the same focal length (nvm: the larger one): inside, the largest "
              "without blank pixels; keep, the "
              "photo's size; all, every pixel of the photo, up to twice its width and height. Blank pixels are masked")
      ->needs(undistort);
  output.number("--quality", options.quality, 1, 100, "N", "JPEG quality of photos that are encoded anew, 1 to 100");
  add_common(*app, options.common, R"(Examples:
  gpvc convert colmap -o for-openmvs --format mvs --undistort
  gpvc convert reconstruction.json --images photos -o for-colmap --format colmap

Photos are copied unchanged unless --undistort or --downscale is given. A lens that the format
cannot express is an error that names the term it would lose.
Masks and alpha channels become masks/NAME.EXT.png for COLMAP (its ImageReader.mask_path, our
--masks), OpenSfM and transforms.json, and NAME.mask.png beside the photo for OpenMVS
(--ignore-mask-label 0). mvs-texturing has no masks, nor have programs that read NVM, for which
they become NAME.EXT.mask.png beside the photo, where gpvc finds them.

)");
  return app;
}

}  // namespace gpvc::cli
