! A small discrete element code in Fortran: the explicit midpoint rule for positions, velocities, attitudes and spins.
! Usage: dem REQUEST.TXT TRAJECTORY.CSV
module scene
  use request
  implicit none
  type body
    real(real64) :: mass, radius, inertia(3)
  end type
  type element
    character(20) :: kind
    integer :: a, b
    real(real64) :: anchor(3), g(3), stiffness, length, exponent, damping, friction
  end type
  type(body), allocatable :: bodies(:)
  type(element), allocatable :: elements(:)
contains
  subroutine read_scene(s)
    real(real64), allocatable, intent(out) :: s(:, :)   ! position 1-3, velocity 4-6, attitude 7-10, omega in body axes 11-13
    integer :: i
    allocate (bodies(int(number('scene.bodies.count'))), elements(int(number('scene.elements.count'))))
    allocate (s(13, size(bodies)))
    do i = 1, size(bodies)
      bodies(i) = body(number(item('bodies', i, 'mass')), number(item('bodies', i, 'shape.radius')), &
                       vector('bodies', i, 'inertia', 3))
      s(1:10, i) = [vector('bodies', i, 'position', 3), vector('bodies', i, 'velocity', 3), vector('bodies', i, 'attitude', 4)]
      s(11:13, i) = turned(s(7:10, i), vector('bodies', i, 'omega', 3), -1)
    end do
    do i = 1, size(elements)
      if (is_off_centre(i)) call unsupported('anchors off the centre')
      if (number(item('elements', i, 'friction')) > 0) call unsupported('friction')
      if (text(item('elements', i, 'cutoff')) == 'zero_force') call unsupported('a force that may not pull')
      elements(i) = element(text(item('elements', i, 'kind')), int(number(item('elements', i, 'a'))) + 1, &
        int(number(item('elements', i, 'b'))) + 1, vector('elements', i, 'anchor_b', 3), vector('elements', i, 'g', 3), &
        number(item('elements', i, 'stiffness')), number(item('elements', i, 'length')), number(item('elements', i, 'exponent')), &
        number(item('elements', i, 'damping')), number(item('elements', i, 'friction')))
    end do
  end subroutine

  logical function is_off_centre(i)   ! an anchor in a body elsewhere than at its centre would make a torque
    integer, intent(in) :: i
    is_off_centre = any(vector('elements', i, 'anchor_a', 3) /= 0)
    if (number(item('elements', i, 'b')) >= 0) is_off_centre = is_off_centre .or. any(vector('elements', i, 'anchor_b', 3) /= 0)
  end function

  pure function cross(a, b)
    real(real64), intent(in) :: a(3), b(3)
    real(real64) :: cross(3)
    cross = [a(2)*b(3) - a(3)*b(2), a(3)*b(1) - a(1)*b(3), a(1)*b(2) - a(2)*b(1)]
  end function

  pure function turned(q, x, way)   ! from body to space axes (way = 1) or back (way = -1)
    real(real64), intent(in) :: q(4), x(3)
    integer, intent(in) :: way
    real(real64) :: turned(3), t(3)
    t = 2*way*cross(q(2:4), x)
    turned = x + q(1)*t + way*cross(q(2:4), t)
  end function

  subroutine pull(force, s, e)
    real(real64), intent(inout) :: force(:, :)
    real(real64), intent(in) :: s(:, :)
    type(element), intent(in) :: e
    real(real64) :: to(3), distance, stretch
    to = e%anchor
    if (e%b > 0) to = s(1:3, e%b)
    to = to - s(1:3, e%a)
    distance = norm2(to)
    if (distance == 0) return
    stretch = distance - e%length
    to = sign(e%stiffness*abs(stretch)**e%exponent, stretch)*to/distance
    force(:, e%a) = force(:, e%a) + to
    if (e%b > 0) force(:, e%b) = force(:, e%b) - to
  end subroutine

  subroutine push(force, s, e, a, b)
    real(real64), intent(inout) :: force(:, :)
    real(real64), intent(in) :: s(:, :)
    type(element), intent(in) :: e
    integer, intent(in) :: a, b
    real(real64) :: n(3), overlap, f(3)
    n = s(1:3, b) - s(1:3, a)
    overlap = bodies(a)%radius + bodies(b)%radius - norm2(n)
    if (overlap <= 0 .or. bodies(a)%radius*bodies(b)%radius == 0) return
    n = n/norm2(n)
    f = (e%stiffness*overlap + e%damping*dot_product(s(4:6, a) - s(4:6, b), n))*n
    force(:, a) = force(:, a) - f
    force(:, b) = force(:, b) + f
  end subroutine

  function rate(s)
    real(real64), intent(in) :: s(:, :)
    real(real64) :: rate(size(s, 1), size(s, 2)), force(3, size(s, 2)), w(3), J(3)
    integer :: i, k, l
    force = 0
    do i = 1, size(elements)
      if (elements(i)%kind == 'spring') call pull(force, s, elements(i))
      do k = 1, size(bodies)
        if (elements(i)%kind == 'uniform_gravity') force(:, k) = force(:, k) + bodies(k)%mass*elements(i)%g
        do l = 1, k - 1
          if (elements(i)%kind == 'contact') call push(force, s, elements(i), l, k)
        end do
      end do
    end do
    do k = 1, size(bodies)
      w = s(11:13, k)
      J = bodies(k)%inertia
      rate(:, k) = [s(4:6, k), force(:, k)/bodies(k)%mass, -dot_product(s(8:10, k), w)/2, &
                    (s(7, k)*w + cross(s(8:10, k), w))/2, merge(cross(J*w, w)/max(J, tiny(J)), 0*w, J > 0)]
    end do
  end function
end module
