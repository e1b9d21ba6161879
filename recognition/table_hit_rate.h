#pragma once

#include "recognition/pair_table.h"
#include "recognition/recognition_model.h"

namespace binpick {

/// h, the share of point pairs measured on a model whose cell of the table holds a pair that puts
/// the model near its place. Eq. (11) of IJRR 2012 takes the table for complete (h = 1); but
/// normals are measured a few degrees wrong, and the table holds a finite set of pairs, so a pair
/// often falls beside what it was to find: on curved bodies, whose pairs spread over many cells,
/// mostly.
///
/// Draws pairs of points of the model's cover, turns their normals as `normal_noise` (rad, standard
/// deviation about each tangent) says, and looks them up in a table of this model alone.
[[nodiscard]] double table_hit_rate(const RecognitionModel& model, const PairTableOptions& options,
                                    double normal_noise);

/// Adds pair points to the model until its hit rate is no less than a twentieth at a noise of 6
/// degrees, as of a normal fitted to the points of a few leaves of a structured-light scan; boxes
/// need some 20 points per diameter, smooth figures 30.
void densify_pair_points(RecognitionModel& model, const PairTableOptions& options);

}  // namespace binpick
