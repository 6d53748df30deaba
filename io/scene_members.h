// The members of a scene's and a model's structs, for what is stored or hashed (members.h).
#pragma once

#include "members.h"
#include "scene.h"
#include "textured_model.h"
#include "view_rules.h"

namespace gpvc {

GPVC_MEMBERS(WorldPoint, x, y, z)
GPVC_MEMBERS(Pose, rotation, centre)
GPVC_MEMBERS(Motion, across, down, turn, step, nearness)
GPVC_MEMBERS(ShiftField, columns, rows, spacing, nodes)
GPVC_MEMBERS(Distortion, k1, k2, p1, p2, k3, max_r2, model, k4, d1, d2, d3, p3, p4, s1, s2, skew, omega, k5, k6, s3, s4,
             alpha, beta, a1, a2, a3, motion, lens_from_frame, max_angle, aligned)
GPVC_MEMBERS(Camera, width, height, fx, fy, cx, cy, distortion)
GPVC_MEMBERS(BandCamera, photo, file, file_from_photo, shift)
GPVC_MEMBERS(View, name, photo, camera, pose, mask, uses_alpha, reduction, number, exposure_value, band_files,
             band_cameras)
GPVC_MEMBERS(Band, name, wavelength_nm, unit)
GPVC_MEMBERS(BandSet, type, bands, composite, black, white, radiometric)
GPVC_MEMBERS(BandPlace, file_from_photo, nearness, error_px)
GPVC_MEMBERS(BadPhoto, view, problem, reason)
GPVC_MEMBERS(SceneFrame, name, rotation, origin, scale, srs)
GPVC_MEMBERS(HashedPhoto, file, hash)
GPVC_MEMBERS(Scene, source, views, srs, offset, other_frames, reference, format, warnings, bad_photos, read_from, files,
             circle_photos, bands, band_places)
GPVC_MEMBERS(Mesh, positions, faces, source_face, file_positions, file_srs, warnings)

}  // namespace gpvc

namespace gpvc::io {

GPVC_MEMBERS(BoxRegion, low, high)
GPVC_MEMBERS(GroundRegion, corners, low, high)
GPVC_MEMBERS(FaceRegion, ranges)
GPVC_MEMBERS(TexCoord, u, v)
// Without its mesh, which is borrowed, and coordinates for an OBJ alone, which no model has that is stored.
template <Like<TexturedModel> Model>
auto members_of(Model& model) {
  auto& [mesh, texcoords, face_texcoords, face_page, obj_texcoords] = model;
  return std::tie(texcoords, face_texcoords, face_page);
}
GPVC_MEMBERS(ModelOptions, offset, up, srs, srs_offset, normals, lit, pageless_faces, obj_style, buffer_limit_bytes,
             copyright, coding)

}  // namespace gpvc::io
