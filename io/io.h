// All public headers of io.
#pragma once

#include "images.h"
#include "mesh.h"
#include "npy.h"
#include "output_file.h"
#include "photos.h"
#include "progress.h"
#include "scene_files.h"
#include "textured_model.h"
