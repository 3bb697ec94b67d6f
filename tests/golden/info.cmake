# SPDX-License-Identifier: GPL-3.0-or-later
cornice_test(info_files golden/info/real_files_test.cpp golden/info/odd_files_test.cpp
             LIBS cornice_info)
