// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/poisson/command.h"

#include "stages/poisson/command_run.h"

namespace cornice::poisson {
namespace {

Option action_option(Command& c, const std::string& word, const std::string& help) {
  return Option("ACTION", c.action, help).positional().required().words({word});
}

std::vector<Option> describe_tile(Command& c) {
  return {
      Option("tile", c.tile, "west,south,east,north of the tile; otherwise the points' own box")
          .unit("m"),
      Option("halo-m", c.halo_m, "points farther from the tile are not used")
          .range(0, 500)
          .unit("m"),
  };
}

std::vector<Option> describe_solve(Command& c) {
  return {
      Option("step-m", c.solve.lattice.step_m,
             "lattice step; time and memory grow with its inverse square")
          .range(0.001, 1000)
          .unit("m"),
      Option("point-weight", c.solve.point_weight,
             "how closely the surface follows points rather than normals")
          .range(0, 1000),
      Option("fill-dem", c.fill_dem, "rasters of heights, used where there are no points"),
      Option("fill-beyond-m", c.fill.beyond_m, "a gap: no point so near in plan")
          .range(0.1, 1000)
          .unit("m"),
      Option("points-per-cell", c.solve.points_per_cell,
             "that a cell must see for its level to be used; more is smoother")
          .above(0)
          .advanced(),
      Option("relaxations", c.solve.relaxations,
             "passes whenever a level is visited; time grows with it")
          .range(1, 1000)
          .advanced(),
  };
}

std::vector<Option> describe_surface(Command& c) {
  return {
      Option("margin-m", c.margin_m, "surface kept beyond the tile; not with neighbours")
          .range(0, 500)
          .unit("m"),
      Option("support-cap-m", c.support.cap_m, "distances to points are exact up to here")
          .above(0)
          .unit("m"),
      Option("density-radius-m", c.support.radius_m, "of the ball that density is counted in")
          .above(0)
          .unit("m")
          .advanced(),
      Option("weld", c.extract.weld,
             "part of a step within which vertices around a node become one; 0: none")
          .range(0, 0.49)
          .advanced(),
  };
}

Option points_option(Command& c) {
  return Option("POINTS", c.points, "oriented points of the tile and its halo, .ply")
      .positional()
      .required();
}

}  // namespace

Stage solve_stage(Command& c) {
  Stage stage;
  stage.name = "poisson";
  stage.description =
      "Solves for the implicit function of a tile, and writes it and its border band";
  stage.options = {
      action_option(c, "solve", "solve"), points_option(c),
      output_option(c.output, "the tile's field"),
      Option("band", c.band, "the border band; otherwise beside the field, .band").output()};
  stage.add(describe_tile(c), "Tile");
  stage.add({Option("band-m", c.band_m, "of a border within which fields are blended")
                 .range(0, 500)
                 .unit("m")},
            "Tile");
  stage.add(describe_solve(c), "Reconstruction");
  stage.examples = {
      "cornice-poisson solve b.ply -o b.field --tile 2600000,1200000,2601000,1201000"};
  stage.run = [&c](StageContext& context) { run_solve(c, context); };
  return stage;
}

Stage extract_stage(Command& c) {
  Stage stage;
  stage.name = "poisson";
  stage.description = "Extracts a tile's surface, which meets its neighbours' bit for bit";
  stage.options = {
      action_option(c, "extract", "extract"),
      Option("FIELD", c.field, "the tile's field").positional().required(),
      output_option(c.output, "mesh, .ply").ending(".ply"),
      Option("neighbours", c.neighbours, "bands of the tiles around; all that take part"),
      Option("tiles", c.tile_list, "text file with the bands of the survey, one a line, instead"),
      Option("points", c.points, "measured points, .ply: for support and density")};
  stage.add(describe_surface(c), "Surface");
  stage.examples = {
      "cornice-poisson extract b.field --neighbours a.band c.band --points b.ply -o b.ply"};
  stage.run = [&c](StageContext& context) { run_extract(c, context); };
  return stage;
}

Stage mesh_stage(Command& c) {
  Stage stage;
  stage.name = "poisson";
  stage.description = "Reconstructs the surface of a tile that has no neighbours";
  stage.options = {action_option(c, "mesh", "mesh"), points_option(c),
                   output_option(c.output, "mesh, .ply").ending(".ply")};
  stage.add(describe_tile(c), "Tile");
  stage.add(describe_solve(c), "Reconstruction");
  stage.add(describe_surface(c), "Surface");
  stage.examples = {"cornice-poisson mesh points.ply -o mesh.ply --step-m 0.5"};
  stage.run = [&c](StageContext& context) { run_mesh(c, context); };
  return stage;
}

Stage choose_stage(Command& c) {
  Stage stage;
  stage.name = "poisson";
  stage.description =
      "Screened Poisson reconstruction: solve, extract, or mesh (both in one); help of each: "
      "cornice-poisson ACTION --help";
  stage.options = {Option("ACTION", c.action, "what to do; must come first")
                       .positional()
                       .required()
                       .words({"solve", "extract", "mesh"})};
  stage.examples = {"cornice-poisson mesh points.ply -o mesh.ply",
                    "cornice-poisson solve b.ply -o b.field --tile 0,0,1000,1000",
                    "cornice-poisson extract b.field --neighbours a.band --points b.ply -o b.ply"};
  stage.run = [&c](StageContext&) { throw UsageError(c.action, "must be the first argument"); };
  return stage;
}

}  // namespace cornice::poisson
