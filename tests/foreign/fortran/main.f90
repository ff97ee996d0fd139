! Reads the request, steps, writes a row for each sample and body.
program main
  use scene
  implicit none
  real(real64), allocatable :: s(:, :)
  character(500) :: path
  real(real64) :: start, interval, h
  integer :: out, i, k, n, stride
  call get_command_argument(1, path)
  call read_request(path)
  call read_scene(s)
  call get_command_argument(2, path)
  open (newunit=out, file=path, status='new', action='write')
  write (out, '(a)') 't,body,x,y,z,vx,vy,vz,qw,qx,qy,qz,wx,wy,wz'
  start = number('times.0')
  interval = number('times.1') - start
  stride = nint(number('stride'))
  h = interval/stride
  do n = 0, int(number('times.count')) - 1
    do k = 1, merge(stride, 0, n > 0)
      s = s + h*rate(s + h/2*rate(s))
      do i = 1, size(bodies)
        s(7:10, i) = s(7:10, i)/norm2(s(7:10, i))
      end do
    end do
    do i = 1, size(bodies)
      write (out, '(es25.17e3,",",i0,13(",",es25.17e3))') start + n*interval, i - 1, s(1:10, i), turned(s(7:10, i), s(11:13, i), 1)
    end do
  end do
end program
