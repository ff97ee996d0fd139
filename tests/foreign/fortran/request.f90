! Reads request.txt, lines of `key value`.
module request
  implicit none
  integer, parameter :: real64 = kind(1d0)
  character(200), allocatable :: keys(:), values(:)
contains
  subroutine read_request(path)
    character(*), intent(in) :: path
    integer :: unit, status, n, i
    open (newunit=unit, file=path, status='old', action='read')
    n = -1
    do while (n < 0 .or. status == 0)
      read (unit, *, iostat=status)
      n = n + 1
    end do
    allocate (keys(n), values(n))
    rewind (unit)
    do i = 1, n
      read (unit, *) keys(i), values(i)
    end do
    close (unit)
  end subroutine

  function text(key) result(found)
    character(*), intent(in) :: key
    character(200) :: found
    integer :: i
    found = '0'
    do i = 1, size(keys)
      if (keys(i) == key) found = values(i)
    end do
  end function

  real(real64) function number(key)
    character(*), intent(in) :: key
    character(200) :: word
    word = text(key)
    read (word, *) number
  end function

  function item(what, i, name) result(key)
    character(*), intent(in) :: what, name
    integer, intent(in) :: i
    character(200) :: key
    write (key, '(a,a,a,i0,a,a)') 'scene.', what, '.', i - 1, '.', name
  end function

  function vector(what, i, name, n) result(found)
    character(*), intent(in) :: what, name
    integer, intent(in) :: i, n
    real(real64) :: found(n)
    integer :: k
    do k = 1, n
      found(k) = number(trim(item(what, i, name))//'.'//char(ichar('0') + k - 1))
    end do
  end function

  subroutine unsupported(why)   ! exit status 77; the last line on stderr says why
    use, intrinsic :: iso_fortran_env, only: error_unit
    character(*), intent(in) :: why
    write (error_unit, '(a)') why
    stop 77, quiet=.true.
  end subroutine
end module
