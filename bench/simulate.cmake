# SPDX-License-Identifier: GPL-3.0-or-later
cornice_add_bench(simulate cornice_simulate_survey cornice_simulate_scene)
target_compile_definitions(bench-simulate PRIVATE CORNICE_SCENES="${PROJECT_SOURCE_DIR}/samples/scenes")
