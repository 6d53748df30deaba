// All that a program needs that textures meshes: reading scenes, meshes and photos, texturing, tilesets.
#pragma once

#include "app/pipeline/pipeline.h"
#include "app/tileset/tileset.h"
#include "io/images.h"
#include "io/mesh.h"
#include "io/photos.h"
#include "io/scene_files.h"
#include "io/textured_model.h"
#include "io/validate.h"
