// The mesh of cylinders.hvi and balls.hvi: gmsh -2 -format msh41 -bin rounds.geo
// Quarters of two disks that touch at the origin, of radius 1 above it and 2 below it, fine there.
Macro Body
  Point(p)     = {0, 0, 0, fine};
  Point(p + 1) = {radius, side*radius, 0, coarse};
  Point(p + 2) = {0, side*radius, 0, coarse};
  Circle(p)    = {p, p + 2, p + 1};
  Line(p + 1)  = {p + 1, p + 2};
  Line(p + 2)  = {p + 2, p};
  Curve Loop(p) = {p, p + 1, p + 2};
  Plane Surface(p) = {p};
Return
p = 10; side = 1; radius = 1; fine = 0.0009; coarse = 0.12;
Call Body;
p = 20; side = -1; radius = 2; fine = 0.0011; coarse = 0.24;
Call Body;
Mesh.MeshSizeExtendFromBoundary = 1;
Physical Curve("upper_skin") = {10};
Physical Curve("top") = {11};
Physical Curve("lower_skin") = {20};
Physical Curve("base") = {21};
Physical Curve("middle") = {12, 22};
Physical Surface("upper") = {10};
Physical Surface("lower") = {20};
