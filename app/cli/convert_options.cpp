#include "app/cli/command_options.h"
#include "app/cli/option_parts.h"

namespace gpvc::cli {

CLI::App* add_convert(CLI::App& parent, ConvertOptions& options) {
  CLI::App* app = parent.add_subcommand("convert", "write a scene for another program");
  add_scene(*app, options.input);
  add_photos(*app, options.input);
  add_masks(*app, options.input);
  add_output(*app, options.out, options.force);
  add_choice(*app, "--format", io::kSceneTargetNames, options.target,
             "COLMAP's text model, mvs-texturing's .cam files, or OpenMVS' scene.mvs")
      ->group("Output");
  CLI::Option* undistort =
      app->add_flag("--undistort", options.undistort, "Write photos without lens distortion, and cameras that say so")
          ->group("Output");
  add_choice(*app, "--frame", pipeline::kFrameRuleNames, options.frame,
             "How far undistorted photos reach, at the same focal length: as far as nothing is blank; the photo's "
             "size; or all of the photo, up to twice its width and height. What is blank is masked")
      ->needs(undistort)
      ->group("Output");
  app->add_option("--quality", options.quality, "Of jpg photos that are written anew, 1 to 100")
      ->type_name("N")
      ->check(in_range(1, 100))
      ->default_str("98")
      ->group("Output");
  add_common(*app, options.common);
  app->footer(
      std::string("Examples:\n"
                  "  gpvc convert colmap -o for-openmvs --format mvs --undistort\n"
                  "  gpvc convert reconstruction.json --images photos -o for-colmap --format colmap\n\n"
                  "Photos are copied as they are unless --undistort or --downscale changes them. A lens that\n"
                  "the format cannot state is refused with the name of the term it would lose.\n"
                  "Masks and alpha channels become masks/NAME.EXT.png for COLMAP (its ImageReader.mask_path, our\n"
                  "--masks) and NAME.mask.png beside the photo for OpenMVS (--ignore-mask-label 0);\n"
                  "mvs-texturing knows none.\n\n") +
      kExitStatus);
  return app;
}

}  // namespace gpvc::cli
