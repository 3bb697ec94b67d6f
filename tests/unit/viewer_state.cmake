# SPDX-License-Identifier: GPL-3.0-or-later
cornice_test(viewer_state unit/viewer_state/frame_budget_test.cpp unit/viewer_state/settings_test.cpp
             LIBS cornice_viewer_app cornice_test_support)
